"""The messages of a ROS 1 bag from its first chunk to its last; used by `bag_contents`.

Source of the format: ROS wiki, Bags/Format/2.0.
"""

import struct
from typing import Any

from rosbags.rosbag1 import Reader

_NUMBER, _STAMP = struct.Struct("<I").unpack_from, struct.Struct("<II").unpack_from
_CONNECTION, _TIME, _MESSAGE = b"\x09\0\0\0conn=", b"\x0d\0\0\0time=", b"\x04\0\0\0op=\x02"


class Chunks(Reader):
    """A bag that is read without its index of single messages, which is larger in memory than what they hold."""

    def open(self) -> None:
        """Open it, and count the messages of each connection."""
        super().open()
        counts = [chunk.connection_counts for chunk in self.chunk_infos]
        self.connections = [
            one._replace(msgcount=sum(count.get(one.id, 0) for count in counts)) for one in self.connections
        ]

    def read_index_data(self, pos: int, indexes: Any) -> None:
        """Nothing."""

    def messages(self, connections: Any = (), start: Any = None, stop: Any = None) -> Any:
        """Connections, times in ns and bytes of the messages, in the order in which they were written."""
        wanted = {one.id: one for one in connections}
        bio: Any = self.bio
        for chunk in sorted(self.chunk_infos, key=lambda one: (one.start_time, one.pos)):
            if wanted.keys() & chunk.connection_counts.keys():
                where = self.chunks[chunk.pos]
                bio.seek(where.datapos)
                # the messages among the records of a chunk
                data = where.decompressor(bio.read(where.datasize))
                at = 0
                while at < len(data):
                    begin = at + 4
                    at = begin + _NUMBER(data, at)[0]
                    header = data[begin:at]
                    begin = at + 4
                    at = begin + _NUMBER(data, at)[0]
                    if at > len(data):
                        raise ValueError("a chunk ends within a record")
                    if _MESSAGE in header:
                        connection = wanted.get(_NUMBER(header, header.index(_CONNECTION) + len(_CONNECTION))[0])
                        if connection is not None:
                            seconds, nanoseconds = _STAMP(header, header.index(_TIME) + len(_TIME))
                            yield connection, seconds * 1_000_000_000 + nanoseconds, data[begin:at]
