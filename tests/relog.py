"""Makes logs with faults out of a good one, whose frames are a POSE_ODOM and a LIDAR_SEMANTIC of one time each.
usage: relog.py GOOD.lcm CASE OUT.lcm   (relog.py --list names the cases)"""
import struct
import sys

SYNC = 0xEDA1DA01
POSE, CLOUD = "POSE_ODOM", "LIDAR_SEMANTIC"
START_US = 1_317_042_145_964_000
SECOND_US = 1_000_000


def read(path):
    """[(event time, channel, message)]"""
    data, at, events = open(path, "rb").read(), 0, []
    while at < len(data):
        sync, _, time_us, name_bytes, data_bytes = struct.unpack_from(">Iqqii", data, at)
        assert sync == SYNC
        at += 28
        name = data[at:at + name_bytes].decode()
        events.append((time_us, name, data[at + name_bytes:at + name_bytes + data_bytes]))
        at += name_bytes + data_bytes
    return events


def write(path, events):
    with open(path, "wb") as out:
        for k, (time_us, name, data) in enumerate(events):
            name = name.encode()
            out.write(struct.pack(">Iqqii", SYNC, k, time_us, len(name), len(data)) + name + data)


def stamp_of(message):
    return struct.unpack_from(">q", message, 8)[0]


def stamped(message, stamp_us):
    return message[:8] + struct.pack(">q", stamp_us) + message[16:]


def restamp(events, poses=None, clouds=None):
    """Events with the stamps of a channel mapped; the log's own times stay."""
    maps = {POSE: poses, CLOUD: clouds}
    return [(t, c, stamped(m, maps[c](stamp_of(m))) if maps.get(c) else m) for t, c, m in events]


def with_extra(events, channel, offset_us):
    """One more message of the channel, the eleventh again, with a stamp that is off by so much."""
    at = [k for k, e in enumerate(events) if e[1] == channel][10]
    time_us, _, message = events[at]
    late = 50_000
    extra = (time_us + late, channel, stamped(message, stamp_of(message) + late + offset_us))
    return events[:at + 2] + [extra] + events[at + 2:]


def nth_poses(events, every):
    seen, out = 0, []
    for event in events:
        if event[1] == POSE:
            seen += 1
            if (seen - 1) % every != 0:
                continue
        out.append(event)
    return out


def since(us):
    return us - START_US


def step_at(fraction_us, step_us):
    return lambda us: us + (step_us if since(us) >= fraction_us else 0)


def with_orientation(events, pick, numbers):
    """Poses with other orientations, of the frames that `pick` picks by number."""
    seen, out = 0, []
    for time_us, channel, message in events:
        if channel == POSE:
            if pick(seen):
                message = message[:64] + struct.pack(">4d", *numbers) + message[96:]
            seen += 1
        out.append((time_us, channel, message))
    return out


def joined(events, later_us):
    later = [(t + later_us, c, stamped(m, stamp_of(m) + later_us)) for t, c, m in events]
    return events + later


NAN = float("nan")
CASES = {
    "good": lambda e: e,
    "odometry_5hz": lambda e: nth_poses(e, 2),
    "odometry_1hz": lambda e: nth_poses(e, 10),
    "odometry_0.5hz": lambda e: nth_poses(e, 20),
    "odometry_late": lambda e: [x for x in e if x[1] != POSE or since(stamp_of(x[2])) >= 2 * SECOND_US],
    "odometry_ends": lambda e: [x for x in e if x[1] != POSE or since(stamp_of(x[2])) <= 2 * SECOND_US],
    "step_back_5s": lambda e: restamp(e, step_at(2 * SECOND_US, -5 * SECOND_US), step_at(2 * SECOND_US, -5 * SECOND_US)),
    "step_back_1h": lambda e: restamp(e, *[step_at(2 * SECOND_US, -3600 * SECOND_US)] * 2),
    "step_ahead_5s": lambda e: restamp(e, *[step_at(2 * SECOND_US, 5 * SECOND_US)] * 2),
    "step_ahead_10h": lambda e: restamp(e, *[step_at(2 * SECOND_US, 36000 * SECOND_US)] * 2),
    "joined_an_hour_apart": lambda e: joined(e, 3600 * SECOND_US),
    "cloud_seconds": lambda e: restamp(e, clouds=lambda us: us // SECOND_US),
    "both_seconds": lambda e: restamp(e, lambda us: us // SECOND_US, lambda us: us // SECOND_US),
    "cloud_milliseconds": lambda e: restamp(e, clouds=lambda us: us // 1000),
    "cloud_nanoseconds": lambda e: restamp(e, clouds=lambda us: us * 1000),
    "both_nanoseconds": lambda e: restamp(e, lambda us: us * 1000, lambda us: us * 1000),
    "both_zero": lambda e: restamp(e, lambda us: 0, lambda us: 0),
    "boot_clock": lambda e: restamp(e, clouds=lambda us: since(us) + 5 * SECOND_US),
    "tai": lambda e: restamp(e, clouds=lambda us: us + 37 * SECOND_US),
    "twice": lambda e: [x for x in e for _ in (0, 1)],
    "no_odometry": lambda e: [x for x in e if x[1] != POSE],
    "odometry_elsewhere": lambda e: [(t, "POSE_BODY" if c == POSE else c, m) for t, c, m in e],
    "clouds_elsewhere": lambda e: [(t, "VELODYNE" if c == CLOUD else c, m) for t, c, m in e],
    "no_orientation": lambda e: with_orientation(e, lambda k: True, (0, 0, 0, 0)),
    "no_orientation_at_first": lambda e: with_orientation(e, lambda k: k < 5, (0, 0, 0, 0)),
    "nan_now_and_then": lambda e: with_orientation(e, lambda k: k % 7 == 3, (NAN, 0, 0, 1)),
    "event_times_zero": lambda e: [(0, c, m) for _, c, m in e],
    "odd_events": lambda e: [y for x in e for y in (x, (x[0], "EMPTY", b""), (x[0], "caf\u00e9", b"abc"))],
}
for _name, _s in (("ahead_0.5s", 0.5), ("ahead_2s", 2), ("ahead_8s", 8), ("ahead_1h", 3600), ("back_1h", -3600)):
    CASES["odometry_" + _name] = lambda e, s=_s: with_extra(e, POSE, int(s * SECOND_US))
    CASES["cloud_" + _name] = lambda e, s=_s: with_extra(e, CLOUD, int(s * SECOND_US))


def main(args):
    if args == ["--list"]:
        print("\n".join(sorted(CASES)))
        return
    good, case, out = args
    # As a robot's clock has them: the stamps of a simulation begin at zero.
    events = read(good)
    first_us = events[0][0]
    events = [(t - first_us + START_US, c, stamped(m, stamp_of(m) - first_us + START_US)) for t, c, m in events
              if c in (POSE, CLOUD)]
    write(out, CASES[case](events))


if __name__ == "__main__":
    main(sys.argv[1:])
