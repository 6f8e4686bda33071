"""ROS 2 bags: a topic with poses is a robot."""

import sys

import numpy as np
import pytest
from rolling_robots import POSES, T

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.report import ReadOptions, read

rosbag2 = pytest.importorskip("rosbags.rosbag2")
typesys = pytest.importorskip("rosbags.typesys")
STORE = typesys.get_typestore(typesys.Stores.LATEST)
KIND = "geometry_msgs/msg/PoseStamped"


def message(t, x, y, theta):
    of = STORE.types
    place = of["geometry_msgs/msg/Point"](x, y, 0.0)
    turned = of["geometry_msgs/msg/Quaternion"](0.0, 0.0, np.sin(theta / 2), np.cos(theta / 2))
    stamp = of["builtin_interfaces/msg/Time"](int(t), round((t - int(t)) * 1e9))
    header = of["std_msgs/msg/Header"](stamp, "arena")
    return of[KIND](header, of["geometry_msgs/msg/Pose"](place, turned))


def bag(path, plugin, topics=4):
    with rosbag2.Writer(path, version=9, storage_plugin=plugin) as writer:
        for n in range(topics):
            topic = writer.add_connection(f"/r{n}/pose", KIND, typestore=STORE)
            for k, t in enumerate((1_700_000_000 + T + 0.004 * n).tolist()):
                raw = STORE.serialize_cdr(message(t, *POSES[k, :, n].tolist()), KIND)
                writer.write(topic, round(t * 1e9), raw)
    return path


@pytest.mark.parametrize("plugin", list(rosbag2.StoragePlugin))
@pytest.mark.parametrize("whole", [True, False])
def test_topics_are_robots_on_a_common_clock(tmp_path, plugin, whole):
    path = bag(tmp_path / "bag", plugin)
    ending = "db3" if "SQLITE" in plugin.name else "mcap"
    run = read(path if whole else next(path.glob(f"*.{ending}")))
    assert run.robots == 4
    for n in range(4):
        there = np.interp(run.t + 0.004 * (3 - n), T, POSES[:, 0, n])
        np.testing.assert_allclose(run.poses[:, 0, n], there, atol=1e-5)
    assert any("/r0/pose, /r1/pose, /r2/pose, /r3/pose" in note for note in run.notes)


def test_one_topic_is_chosen_by_its_name(tmp_path):
    path = bag(tmp_path / "bag", rosbag2.StoragePlugin.SQLITE3)
    run = read(path, ReadOptions(array="/r2/pose"))
    np.testing.assert_allclose(run.poses[:, :2, 0], POSES[:, :2, 2], atol=1e-9)
    with pytest.raises(LogError, match="no topic with poses"):
        read(path, ReadOptions(array="/r9/pose"))


def test_without_the_extra_the_line_to_install_it_is_told(tmp_path, monkeypatch):
    path = bag(tmp_path / "bag", rosbag2.StoragePlugin.SQLITE3)
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    with pytest.raises(LogError, match=r"pip install 'posflock-robotarium\[ros\]'"):
        read(path)
