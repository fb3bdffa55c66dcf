"""What `reference.py` puts around the tables that it makes from the code."""

from __future__ import annotations

PARAMETERS = """\
# Parameters

Made by `python -m artrec_ros.tools.reference parameters`; the text comes from `artrec_ros/core/base/config/`.
[config/all_parameters.yaml](../config/all_parameters.yaml) has all of them with their defaults, to copy from. The
method's own numbers, which few have reason to change, are [parameters for experts](expert_parameters.md).

`artrec_node` and `artrec replay --params-file` read the same ROS parameter file. Offline it is read without ROS: a
section `/**:` applies to every node, the section of a node `artrec...` (or else of the one that has `objects`) goes
before it, other nodes' sections are passed over. Dots in names are nesting in YAML. A wrong type or value is refused
with its key and what would be valid. So is a wrong name, by `artrec`; the node, whose file may serve other nodes too,
warns of it and names the nearest one that there is.
`artrec replay` saves all parameters of this page, defaults included, as `parameters.yaml` beside its results: again
such a file.

```yaml
/**:
  ros__parameters:
    objects: [red, blue]
    red: {object_file: objects/quadruped.yaml, constraint_file: constraints/quadruped.yaml, label: 3}
    blue: {object_file: objects/quadruped.yaml, constraint_file: constraints/quadruped.yaml, label: 2}
    image: {kind: labels}
    recognizer: {time_budget_ms: 500.0}
```

Paths are relative to the parameter file (to `config_dir` where that is given), or `package://PACKAGE/PATH`; within
braces ROS' own reader wants the latter in quotes.

While the node runs, these can be changed, several at once or none: {live} (of `expert.` those
that it was given when it started). Files are read again only where labels change.

*Read* says which way of recognition reads a parameter ([method.md](method.md)): markers one by one in the *image
plane*; whole objects in *space*; whole flat objects *facing* the camera, in images without calibration; profile
*paper*. One that is changed where no way that is taken reads it is told by name: by the node's log, `artrec replay`,
`artrec inspect`.
"""

EXPERT = """\
# Parameters for experts

Made by `python -m artrec_ros.tools.reference expert`; the text comes from `artrec_ros/core/base/config/`.

The method's own numbers, each under the room of `artrec_ros/core` that it belongs to. They stand under `expert` in
parameter files, and are read by the same commands as the [other parameters](parameters.md), `artrec tune` included:

```yaml
/**:
  ros__parameters:
    expert: {alignment: {coarse_keep: 100}, grouping: {max_scale_ratio: 1.5}}
```

The node declares only those that it was given at the start; these can be changed while it runs. *Origin* says where a
default comes from. Many were chosen by hand and stand on a plateau: *2/3: right -1 of 244, 4/3: +2* says how many
objects more or less were right in every component when this number alone was changed by a third either way
(`benchmarks/sensitivity.py` on 160 frames of quadrupeds, a crowd of them, a doll, a board, the excavator, the
tutorial's forklift and six objects made up at random, 283 of them found). Any change of the search moves it by up to
three by chance; *found* is told where three or more were lost. *Facing*: of the overhead robots and of flat objects
made up at random, without calibration; numbers of `votes`, `fit` and `search` that say nothing of them change no more
than three there, either.
"""

TOPICS = """\
# Topics

Made by `python -m artrec_ros.tools.reference topics`; the text comes from `artrec_ros/io/messages/node_topics.py`.

All names but `/diagnostics` are relative to the node's namespace, and can be remapped. `{{object}}` is each name in the
parameter `objects`. Every message bears the stamp of the image that it is about, and its frame, but for what is told in
[pixels](#pixels). Only messages of common_interfaces are used. `artrec inspect PARAMETERS IMAGES` says which of them
will stay empty, and why.

## Subscribed

{inputs}

Reliability is that of the publishers (`qos_reliability: auto`), and so is durability. Where
recognition does not keep up with them the newest image is looked at, and those that it overtakes are counted as
dropped; where it does, on average, a few wait for one that takes long (`queue_size`).

## Published

{outputs}

Reliable, volatile. A subscriber that asks for more hears nothing, and is named in `/diagnostics`. With `publish_tf` the
frames of objects with a pose in space also go to tf: `red_0`, with the node's namespace before it, under the image's
frame.

Messages about an object are made only while somebody subscribes to their topic.

## Poses in space

`poses`, `robots`, `pose` and tf hold objects whose pose in space is known. It takes a calibration. The pose is

- that of a fit, where the object file tells where its markers sit;
- else by size: a marker of known size tells by its scale how far off it is, and by its place in the image in which
  direction. It is taken to lie parallel to the image plane; how far it is tilted is not known. The covariance says so:
  a deviation of 17.5° about x and y (half of what is found at all), and of the depth what such a tilt and half a pixel
  of the outline make of it: 6 % where a square marker is 40 pixels wide, 11 % where it is 10.

It is the pose of the object's frame; an object without places of markers has that of the marker which shows its
required component (x right, y up, z out of the marker). A pose that is told in another frame than the image's is sent
in that one: where a name has poses in several frames, as a message for each.

With `tracking.smooth` poses and joints are those of a filter over time, and `pose` has its covariance
([method.md](method.md#from-frame-to-frame)); else each is what one image says. Either way `robots` has `twist` and
`joint_states` `velocity`, from the filter, for objects seen at least twice: of the object's origin, m/s, and about the
axes, rad/s, along the axes of the header's frame, relative to the camera or the plane whose it is. Where none is known
they are empty; NaN is what is not known of one of several.

With `tracking.predict` an object that is missed goes on being sent for so long, where it is expected, as if it were
seen, but for `pose` and `image_components`. In `markers` and `debug/image` it is faint.

## Pixels

`image_poses`, `image_robots` and `image_components` hold every object that was found, calibrated or not; `markers` hold
those without a pose in space in the same way. They are pixels, not metres, in a frame of their own: `camera_image`
where the image's is `camera` (`image` where it has none). Its origin is the centre of the first pixel, x runs right,
y down, z into the picture. No transform leads there. A viewer that has it as its fixed frame draws a pixel as a metre:
640 × 480 pixels as a field of 640 × 480 m, to be looked at from below (RViz: the saved view *Image*).

## Diagnostics

| status | tells |
| --- | --- |
| `input` | rate; images processed, failed (not usable), dropped (a newer one came), lost (never arrived); last error |
| `calibration` | whether metric poses can be told, and why not; and whether images' own was used |
| `recognition` | objects found; time from reception to publication, the recogniser's part of it, the rest: ms |
| `output` | subscribers that cannot hear; other nodes that publish under the same names |

`input` warns where most images are dropped or lost. `hardware_id` is the frame that images bear, or the topic until one
has come.

## Lifecycle

The node is a lifecycle node: `~/change_state`, `~/get_state` and their kin. By default (`autostart`) it configures and
activates itself. Configuring reads the files anew; deactivating unsubscribes and deletes the markers; what
is under way then is not published. After `shutdown` the process stays, its node finalized, until SIGINT or SIGTERM
ends it.
"""

YAML = """\
# Every parameter with its default, unit and range. Made by `python -m artrec_ros.tools.reference yaml`.
# Copy what you change: what is left out keeps its default. Empty lists are commented out: ROS cannot tell their type.
/**:
  ros__parameters:
    objects: [red]                # names; each has a section of its own
"""
