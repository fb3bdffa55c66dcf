"""Messages counted as they are read, and held against what their bag says of itself: no loss is silent."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping

from .recovery import RawMessage


class Tally:
    """Of a bag's topics that were read from beginning to end."""

    def __init__(self) -> None:
        self._read: dict[str, int] = {}
        self._twice: dict[str, int] = {}

    def over(self, messages: Iterable[RawMessage], names: Collection[str]) -> Iterator[RawMessage]:
        """All messages of these topics, passed on; counted once the last one was asked for."""
        read, twice = Counter[str](), Counter[str]()
        last: dict[str, RawMessage] = {}
        for message in messages:
            before = last.get(message.topic)
            read[message.topic] += 1
            twice[message.topic] += before is not None and before.log_ns == message.log_ns and before == message
            last[message.topic] = message
            yield message
        self._read.update({name: read[name] for name in names})
        self._twice.update({name: twice[name] for name in names})

    def problems(self, declared: Mapping[str, int], indexed: Mapping[str, int]) -> Iterator[str]:
        """:param declared, indexed: messages by topic, of metadata.yaml and of the files' indices or statistics."""
        for name, count in self._read.items():
            for wanted, whose in ((declared.get(name), "metadata.yaml tells"), (indexed.get(name), "its index tells")):
                if wanted is not None and wanted != count:
                    yield f"'{name}': {count} messages were read, but {whose} of {wanted}{_lost(wanted - count)}"
                    break
            if self._twice[name]:
                yield f"'{name}': {self._twice[name]} messages are there twice: others may have been written over"


def _lost(count: int) -> str:
    return f": {count} {'is' if count == 1 else 'are'} lost" if count > 0 else ""
