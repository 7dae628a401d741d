#!/usr/bin/python3 -B
"""Writes a log as ROS 1 bags with ROS's own writer (Debian's python3-rosbag), converts them back and holds the logs against each other:
byte for byte where the bag has the odometry and the body's clouds, point by point where it has transforms and a tilted sensor. Then bags
that are cut, damaged, or none.
usage: tests/rosbag_test.py [BUILD_DIR] [OUT_DIR] [LOG.lcm]     Without a log: a drive through the simulator's yard.
Exit: 0 passed, 1 a bag was converted wrongly, 77 skipped: python3-rosbag is not installed."""
import math
import pathlib
import struct
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import relog

try:
    import genpy
    import rosbag
    from geometry_msgs.msg import TransformStamped
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import PointCloud2, PointField
    from std_msgs.msg import String
    from tf2_msgs.msg import TFMessage
except ImportError as error:
    print(f"skipped: {error} (tools/install_deps.sh installs python3-rosbag and its messages)")
    sys.exit(77)

CLOUD, POSE = "LIDAR_SEMANTIC", "POSE_ODOM"
TILT = (0.0, math.sin(0.2), 0.0, math.cos(0.2))  # xyzw, of the sensor on the body
MOUNT = (0.3, -0.1, 0.5)                         # m


class Failed(Exception):
    pass


def check(condition, text):
    if not condition:
        raise Failed(text)
    print("ok:", text)


def pose_of(message):
    """position and wxyz of a bot_core.pose_t"""
    values = struct.unpack_from(">16d", message, 16)
    return values[0:3], values[6:10]


def text_at(message, at):
    size = struct.unpack_from(">i", message, at)[0]
    return message[at + 4:at + 4 + size - 1].decode(), at + 4 + size


def cloud_of(message):
    """The fields of a bot_core.pointcloud2_t, as ROS's PointCloud2"""
    cloud, at = PointCloud2(), 20  # behind fingerprint, utime and seq
    cloud.header.frame_id, at = text_at(message, at)
    cloud.height, cloud.width, fields = struct.unpack_from(">iii", message, at)
    at += 12
    for _ in range(fields):
        name, at = text_at(message, at)
        offset, datatype, count = struct.unpack_from(">ibi", message, at)
        at += 9
        cloud.fields.append(PointField(name, offset, datatype, count))
    big, cloud.point_step, cloud.row_step, size = struct.unpack_from(">biii", message, at)
    at += 13
    cloud.is_bigendian = bool(big)
    cloud.data = message[at:at + size]
    cloud.is_dense = True
    return cloud


def points_of(cloud):
    offset = {f.name: f.offset for f in cloud.fields}
    return [struct.unpack_from("<fff", cloud.data, k * cloud.point_step + offset["x"]) for k in range(cloud.width * cloud.height)]


def time_of(us):
    return genpy.Time(us // 1_000_000, us % 1_000_000 * 1000)


def rotate(q, v):
    x, y, z, w = q
    t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])]
    return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0]]


def stamp(header, us, frame):
    header.stamp, header.frame_id = time_of(us), frame


def write_plain(events, path, compression):
    """Clouds in the body's frame and odometry of it; something else beside."""
    with rosbag.Bag(str(path), "w", compression=compression) as bag:
        for us, channel, message in events:
            if channel == POSE:
                position, wxyz = pose_of(message)
                odometry = Odometry()
                stamp(odometry.header, us, "odom")
                odometry.child_frame_id = "base_link"
                p, q = odometry.pose.pose.position, odometry.pose.pose.orientation
                (p.x, p.y, p.z), (q.w, q.x, q.y, q.z) = position, wxyz
                bag.write("/odometry", odometry, time_of(us))
                bag.write("/chatter", String("hello"), time_of(us))
            elif channel == CLOUD:
                cloud = cloud_of(message)
                stamp(cloud.header, us, "base_link")
                bag.write("/labelled", cloud, time_of(us))


def transform(parent, child, position, xyzw, us):
    t = TransformStamped()
    stamp(t.header, us, parent)
    t.child_frame_id = child
    (t.transform.translation.x, t.transform.translation.y, t.transform.translation.z) = position
    (t.transform.rotation.x, t.transform.rotation.y, t.transform.rotation.z, t.transform.rotation.w) = xyzw
    return t


def write_tilted(events, path):
    """Clouds of a sensor that is tilted on the body, and transforms instead of odometry."""
    back = (-TILT[0], -TILT[1], -TILT[2], TILT[3])
    with rosbag.Bag(str(path), "w") as bag:
        first = events[0][0]
        bag.write("/tf_static", TFMessage([transform("/base_link", "lidar", MOUNT, TILT, first)]), time_of(first))
        for us, channel, message in events:
            if channel == POSE:
                position, (w, x, y, z) = pose_of(message)
                bag.write("/tf", TFMessage([transform("odom", "base_link", position, (x, y, z, w), us)]), time_of(us))
            elif channel == CLOUD:
                cloud = cloud_of(message)
                stamp(cloud.header, us, "lidar")
                data, step = bytearray(cloud.data), cloud.point_step
                for k, p in enumerate(points_of(cloud)):
                    moved = rotate(back, [a - b for a, b in zip(p, MOUNT)])
                    struct.pack_into("<fff", data, k * step, *moved)
                cloud.data = bytes(data)
                bag.write("/points", cloud, time_of(us))


def convert(build, bag, out, *more):
    return subprocess.run([build / "hgg-convert", "rosbag", bag, "-o", out, *more], capture_output=True, text=True)


def same_log(build, events, log, out, compression):
    bag, back = out / f"{compression}.bag", out / f"{compression}.lcm"
    write_plain(events, bag, compression)
    done = convert(build, bag, back)
    check(done.returncode == 0 and back.read_bytes() == log.read_bytes(), f"chunks of {compression}: the same log, byte for byte {done.stderr}")


def near_log(build, events, out):
    bag, back = out / "tilted.bag", out / "tilted.lcm"
    write_tilted(events, bag)
    done = convert(build, bag, back)
    check(done.returncode == 0, f"transforms: converted {done.stderr}")
    worst, events_back = 0.0, relog.read(back)
    check([(e[0], e[1]) for e in events_back] == [(e[0], e[1]) for e in events], "transforms: the same messages at the same times")
    for (_, channel, a), (_, _, b) in zip(events, events_back):
        pairs = zip(points_of(cloud_of(a)), points_of(cloud_of(b))) if channel == CLOUD else [(pose_of(a)[0], pose_of(b)[0])]
        worst = max([worst, *(math.dist(p, q) for p, q in pairs)])
    check(worst < 1e-4, f"transforms: points and poses within {worst:.1e} m")


def bad_bags(build, events, out):
    whole = (out / "none.bag").read_bytes()
    cut = out / "cut.bag"
    cut.write_bytes(whole[:len(whole) * 6 // 10])
    done = convert(build, cut, out / "cut.lcm")
    back = relog.read(out / "cut.lcm")
    check(done.returncode == 0 and "cut" in done.stderr and 0 < len(back) < len(events) and
          all(a[2] == b[2] for a, b in zip(events, back)), f"a cut bag: {len(back)} of {len(events)} messages, and said so")
    damaged = bytearray((out / "lz4.bag").read_bytes())
    middle = len(damaged) // 2
    damaged[middle:middle + 64] = bytes(64)
    (out / "damaged.bag").write_bytes(damaged)
    done = convert(build, out / "damaged.bag", out / "damaged.lcm")
    check(done.returncode in (0, 2) and "hgg-convert:" in done.stderr, "a damaged bag: said so")
    (out / "text.bag").write_text("no bag\n" * 100)
    for path in (out / "text.bag", out / "absent.bag"):
        done = convert(build, path, out / "none.lcm")
        check(done.returncode == 2 and str(path) in done.stderr, f"{path.name}: refused")
    done = subprocess.run([build / "hgg-convert", "rosbag", out / "none.bag", "--list"], capture_output=True, text=True)
    check(done.returncode == 0 and "/chatter" in done.stdout and "LIDAR_SEMANTIC, labels of 'label'" in done.stdout, "--list shows what is used for what")
    before = (out / "none.bag").read_bytes()
    done = convert(build, out / "none.bag", out / "none.bag")
    check(done.returncode == 2 and (out / "none.bag").read_bytes() == before, "the bag's own name for the log: refused, the bag is as it was")
    done = convert(build, out / "none.bag", out / "none.lcm", "--label-field", "colour")
    check(done.returncode == 2 and "colour" in done.stderr, "a field that is not there: refused")
    done = convert(build, out / "none.bag", out / "none.lcm", "--body-frame", "camera")
    check(done.returncode == 2 and "camera" in done.stderr, "frames that nothing joins: refused, and what helps")


def main():
    root = pathlib.Path(__file__).resolve().parent.parent
    build = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else root / "build")
    out = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else build / "rosbag")
    out.mkdir(parents=True, exist_ok=True)
    log = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else out / "yard.lcm"
    if len(sys.argv) <= 3:
        subprocess.run([build / "hgg-sim", "yard", "-o", log, "--truth", out / "truth", "--frames", "8"], check=True, capture_output=True)
        events = [e for e in relog.read(log) if e[1] in (POSE, CLOUD)]
        relog.write(log, events)
    events = relog.read(log)
    try:
        for compression in ("none", "bz2", "lz4"):
            same_log(build, events, log, out, compression)
        near_log(build, events, out)
        bad_bags(build, events, out)
    except Failed as error:
        print("FAILED:", error)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
