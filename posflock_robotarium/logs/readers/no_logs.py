"""Files that are no logs, or hold one that has to be taken out first: what each is, what to do."""

from __future__ import annotations

_UNPACK = "unpack it first, and report on what was in it"
_PRINTED = (
    "messages as ros2 topic echo prints them: echo them again with --csv, or with rostopic echo -p"
)
#: First bytes, and what is to be said of such a file.
_STARTS = (
    (b"\x1f\x8b", f"compressed with gzip: {_UNPACK} (gunzip, or tar -xzf)"),
    (b"BZh", f"compressed with bzip2: {_UNPACK} (bunzip2, or tar -xjf)"),
    (b"\xfd7zXZ", f"compressed with xz: {_UNPACK} (unxz, or tar -xJf)"),
    (b"7z\xbc\xaf", f"a 7-Zip archive: {_UNPACK}"),
    (b"PK\x03\x04", "an Excel workbook or another archive: save the sheet as CSV, or unpack it"),
    (b"\xd0\xcf\x11\xe0", "an Excel workbook of old: save the sheet as CSV"),
    (b"PAR1", "a Parquet file: write it as CSV (pandas: read_parquet, to_csv)"),
    (b"%PDF", "a PDF document, no log"),
    (
        b"#ROSBAG",
        "a bag of ROS 1: convert it (pip install rosbags; rosbags-convert --src x.bag --dst x), or "
        "write a topic as CSV with rostopic echo -b x.bag -p /topic",
    ),
    (b"header:", _PRINTED),
    (b"---\nheader:", _PRINTED),
    (b"<", "a web page or XML, no log: was it downloaded as it is shown?"),
)
_JSON = "JSON: write its poses as CSV, or as .npz with arrays t (T,) and poses (T, 3, N)"


def no_log(start: bytes) -> str | None:
    """Return what a file is whose bytes are no table; None where it may be one.

    Parameters
    ----------
    start : bytes
        Its beginning, or all of it.
    """
    begin = start[:512].removeprefix(b"\xef\xbb\xbf").lstrip()
    if begin[:1] in (b"{", b"["):
        return _JSON
    if start[257:262] == b"ustar":
        return f"a tar archive: {_UNPACK} (tar -xf)"
    return next((said for mark, said in _STARTS if begin.startswith(mark)), None)
