"""Prints what is made from the code: docs/parameters.md, docs/expert_parameters.md, docs/topics.md and
config/all_parameters.yaml.

python -m artrec_ros.tools.reference parameters|expert|topics|yaml
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence

from ..core.base.config import (
    PATHS,
    ClassConfig,
    FloorConfig,
    ImageConfig,
    NodeConfig,
    ObjectConfig,
    PlaneConfig,
    RecognizerConfig,
    SceneConfig,
    TrackingConfig,
)
from ..io.messages.node_topics import INPUTS, OUTPUTS, NodeTopic
from ..io.parameters.specs import LIVE, Spec, expert_rooms, offline_rooms, specs_of

_INTRO = """\
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

_EXPERT = """\
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

_SECTIONS: tuple[tuple[str, str, type], ...] = (
    ("Objects", "`objects` lists names; these become topics. Each has, under its name:", ObjectConfig),
    ("Images", "Under `image`:", ImageConfig),
    ("Classes", "`image.classes` lists names, the first wins a pixel. Each has, under `image.NAME`:", ClassConfig),
    ("Recogniser", "Under `recognizer`:", RecognizerConfig),
    (
        "Scene",
        "What is known of the scene ([field.md](field.md)); all of it is optional. Under `scene`:",
        SceneConfig,
    ),
    (
        "Plane",
        "Its points are changed both at once (`ros2 param load`, `set_parameters_atomically`). Under `scene.plane`:",
        PlaneConfig,
    ),
    ("Floor", "Of calibrated images, for objects that are found in space. Under `scene.floor`:", FloorConfig),
    ("Tracking", "Under `tracking`:", TrackingConfig),
    ("Node", "At the top level:", NodeConfig),
)

_COLUMNS = ("name", "type", "default", "valid", "meaning")
_WAYS = {"plane": "image plane", "space": "space", "facing": "facing", "paper": "paper"}
_TYPES = {int: "integer", float: "number", str: "text", bool: "true/false"}


_TOPICS = """\
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
| `calibration` | whether metric poses can be told, and why not |
| `recognition` | objects found; time from reception to publication, the recogniser's part of it, the rest: ms |
| `output` | subscribers that cannot hear; other nodes that publish under the same names |

`input` warns where most images are dropped or lost. `hardware_id` is the frame that images bear, or the topic until one
has come.

## Lifecycle

The node is a lifecycle node: `~/change_state`, `~/get_state` and their kin. By default (`autostart`) it configures and
activates itself. Configuring reads the files anew; deactivating unsubscribes and deletes the markers; what
is under way then is not published.
"""

_YAML = """\
# Every parameter with its default, unit and range. Made by `python -m artrec_ros.tools.reference yaml`.
# Copy what you change: what is left out keeps its default. Empty lists are commented out: ROS cannot tell their type.
/**:
  ros__parameters:
    objects: [red]                # names; each has a section of its own
"""
_PATHS = {"object_file": "objects/quadruped.yaml", "constraint_file": "constraints/quadruped.yaml", "label": 3}


def parameters_page() -> str:
    """docs/parameters.md."""
    parts = [_INTRO.replace("{live}", ", ".join(f"`{name}`" for name in LIVE))]
    for title, intro, config in _SECTIONS:
        specs = specs_of(config)
        read = any(spec.paths != PATHS for spec in specs)
        rows = [(*_row(spec), _read(spec)) if read else _row(spec) for spec in specs]
        parts.append(f"## {title}\n\n{intro}\n\n{_table((*_COLUMNS, 'read') if read else _COLUMNS, rows)}")
    return "\n".join(parts)


def expert_page() -> str:
    """docs/expert_parameters.md."""
    parts = [_EXPERT]
    for name, config in expert_rooms().items():
        rows = [(*_row(spec), _read(spec), spec.origin) for spec in specs_of(config)]
        if rows:
            parts.append(
                f"{_about(name, config)} Under `expert.{name}`:\n\n{_table((*_COLUMNS, 'read', 'origin'), rows)}"
            )
    for name, config in offline_rooms().items():
        rows = [(*_row(spec), spec.origin) for spec in specs_of(config)]
        parts.append(f"{_about(name, config)} Not in parameter files.\n\n{_table((*_COLUMNS, 'origin'), rows)}")
    return "\n".join(parts)


def _about(name: str, config: type) -> str:
    return f"## {name}\n\n{' '.join(str(config.__doc__).split())}"


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [columns, ["---"] * len(columns), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _read(spec: Spec) -> str:
    return "always" if spec.paths == PATHS else ", ".join(_WAYS[way] for way in spec.paths)


def topics_page() -> str:
    """docs/topics.md."""
    return _TOPICS.format(inputs=_topic_table(INPUTS), outputs=_topic_table(OUTPUTS))


def _topic_table(topics: Sequence[NodeTopic]) -> str:
    rows = [(f"`{t.name}`", t.type.replace("/msg", ""), str(t.depth), t.meaning) for t in topics]
    return _table(("topic", "type", "queue", ""), rows).rstrip("\n")


def parameters_yaml() -> str:
    """config/all_parameters.yaml."""
    parts = [_YAML, _yaml_section("red", ObjectConfig, _PATHS), _yaml_section("image", ImageConfig)]
    parts += ["      # classes: [pale]\n", _yaml_section("pale", ClassConfig, None, "      # ")]
    parts += [_yaml_section("recognizer", RecognizerConfig), _yaml_section("scene", SceneConfig)]
    parts += [_yaml_section("plane", PlaneConfig, None, "      ")]
    parts += [_yaml_section("floor", FloorConfig, None, "      "), _yaml_section("tracking", TrackingConfig)]
    parts += [_yaml_line(spec, spec.default, "    ") for spec in specs_of(NodeConfig)]
    parts += ["    # expert:                      # the method's own numbers\n"]
    rooms = {name: room for name, room in expert_rooms().items() if specs_of(room)}
    return "".join([*parts, *(_yaml_section(name, room, None, "    #   ") for name, room in rooms.items())])


def _yaml_section(name: str, config: type, values: Mapping[str, object] | None = None, indent: str = "    ") -> str:
    lines = [_yaml_line(spec, (values or {}).get(spec.name, spec.default), indent + "  ") for spec in specs_of(config)]
    return "".join([f"{indent}{name}:\n", *lines])


def _yaml_line(spec: Spec, value: object, indent: str) -> str:
    # ROS takes 1 for an integer even where a number is declared: always with a point
    text = json.dumps(list(value) if isinstance(value, tuple) else value)
    limits = ", ".join(filter(None, [spec.unit, _valid(spec).replace("`", "")]))
    about = f"{spec.description} [{limits}]" if limits else spec.description
    unset = "# " if value == () and "#" not in indent else ""
    return f"{indent}{unset}{f'{spec.name}: {text}':<34}  # {about}\n"


def _row(spec: Spec) -> tuple[str, ...]:
    kind = _TYPES[spec.type] + (" list" if spec.is_list else "")
    meaning = f"{spec.description} [{spec.unit}]" if spec.unit else spec.description
    return f"`{spec.name}`", kind, _default(spec), _valid(spec), meaning


def _default(spec: Spec) -> str:
    if spec.default in ("", ()) or (spec.low is not None and not spec.is_list and spec.default < spec.low):
        return ""
    return f"`{_listed(spec.default)}`" if spec.is_list else f"`{spec.default}`"


def _listed(values: Sequence[object]) -> str:
    return "[" + ", ".join(map(str, values)) + "]"


def _valid(spec: Spec) -> str:
    if spec.choices:
        return ", ".join(f"`{c}`" for c in spec.choices)
    low, high = (None if bound is None else f"{bound:g}" for bound in (spec.low, spec.high))
    if low is not None and high is not None:
        return f"{low} to {high}" + (f", {spec.length} of them" if spec.length else "")
    return f"from {low}" if low is not None else f"to {high}" if high is not None else ""


_PAGES = {"parameters": parameters_page, "expert": expert_page, "topics": topics_page, "yaml": parameters_yaml}

if __name__ == "__main__":
    page = (sys.argv[1:] or ["parameters"])[0]
    if page not in _PAGES:
        sys.exit(f"usage: python -m artrec_ros.tools.reference {'|'.join(_PAGES)}")
    sys.stdout.write(_PAGES[page]())
