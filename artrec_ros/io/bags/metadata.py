"""What a rosbag2 folder's metadata.yaml tells: its files, and how many messages each topic has."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import yaml

STORAGES = {"mcap": ".mcap", "sqlite3": ".db3"}
BAG_SUFFIXES = (".bag", *STORAGES.values())


@dataclass(frozen=True)
class Metadata:
    """:param files: names of the storage files. :param counts: messages by topic. Both empty: there is none.
    :param types: of messages, by topic. :param problem: why it says nothing though it is there, a line for the user."""

    files: tuple[str, ...] = ()
    counts: Mapping[str, int] = field(default_factory=dict)
    types: Mapping[str, str] = field(default_factory=dict)
    problem: str = ""

    @classmethod
    def of(cls, path: Path) -> Metadata:
        """Of a bag's folder; nothing where metadata.yaml is missing, as after a crash of the recorder, or damaged."""
        file = path / "metadata.yaml"
        if not file.is_file():
            return cls()
        try:
            content = yaml.safe_load(file.read_text(encoding="utf-8"))
            about = content["rosbag2_bagfile_information"]
            files = tuple(Path(name).name for name in about["relative_file_paths"])  # older versions list whole paths
            topics = [(t["topic_metadata"], t["message_count"]) for t in about["topics_with_message_count"] or ()]
            counts = {str(topic["name"]): int(count) for topic, count in topics}
            types = {str(topic["name"]): str(topic.get("type")) for topic, _ in topics}
        except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError):
            return cls(problem="metadata.yaml tells nothing: it is empty or damaged (ros2 bag reindex writes it anew)")
        return cls(files, counts, types)

    def gaps(self, folder: Path, topics: Collection[str]) -> Iterator[str]:
        """Topics and files that it should tell of and does not, or the other way round."""
        for name, count in self.counts.items():
            if count > 0 and name not in topics:
                yield f"metadata.yaml tells of {count} messages on '{name}', which no file has"
        suffixes = {storage_suffix(Path(name)) for name in self.files}
        for file in sorted(folder.iterdir()) if self.files else ():
            if file.name not in self.files and storage_suffix(file) in suffixes:
                yield f"metadata.yaml does not list {file.name}, which is not read"


def storage_suffix(path: Path) -> str:
    """.mcap of 'a.mcap' and of 'a.mcap.zstd', .bag of 'a.bag.active', whose recorder never closed it."""
    return Path(path.stem).suffix if path.suffix in (".zstd", ".active") else path.suffix


def is_storage(path: Path) -> bool:
    return storage_suffix(path) in BAG_SUFFIXES
