#!/usr/bin/env python3
"""Asks a running hggmap for a place in words and leads the robot there.

    lcm-gen -p --ppath=types ../../lcmtypes/*.lcm      # or of an installed hggmap: PREFIX/share/hggmap/lcmtypes
    PYTHONPATH=types ./go_to.py "the bench next to the tree" ["udpm://239.255.76.67:7667?ttl=0"]

Prints the answer, then publishes the next point of the path as NAV_TARGET (bot_core.pose_t) until the robot is there.
Needs the Python module of LCM (pip install lcm). Exit codes: 0 there, 1 no such thing or no way, 2 no answer, or bad usage.
"""
import math
import sys
import time

import lcm
from bot_core import pose_t
from hgg import goal_query_t, goal_reply_t, graph_update_t

AHEAD, THERE = 0.8, 0.3  # m: how far ahead the robot is led, how near is near enough
ASK_AGAIN, PATIENCE = 1.0, 15.0  # s


class Client:
    def __init__(self, bus, text):
        self.bus, self.things, self.reply, self.robot = bus, {}, None, None
        self.why = "does hggmap run?"  # there is no answer
        self.query = goal_query_t()
        self.query.utime = self.query.request_id = time.time_ns() // 1000
        self.query.client, self.query.text, self.query.with_goal = "go_to.py", text, True
        bus.subscribe("MAP_OBJECTS", self.on_graph)
        bus.subscribe("POSE_MAP", self.on_pose)
        bus.subscribe("GOAL_REPLY", self.on_reply)

    def on_graph(self, channel, data):
        update = graph_update_t.decode(data)
        self.things.update((thing.id, thing.name) for thing in update.objects)
        for gone in update.removed:
            self.things.pop(gone, None)

    def on_pose(self, channel, data):
        self.robot = pose_t.decode(data)

    def on_reply(self, channel, data):
        reply = goal_reply_t.decode(data)
        ours = reply.client == self.query.client and reply.request_id == self.query.request_id
        if ours and reply.status == goal_reply_t.FAILED:
            self.why = reply.text  # ask again
        elif ours:
            self.reply = reply

    def ask(self):
        start = again = time.monotonic()
        while not self.reply and time.monotonic() < start + PATIENCE:  # the bus may lose messages: ask until answered
            if time.monotonic() >= again:
                self.bus.publish("GOAL_QUERY", self.query.encode())
                again += ASK_AGAIN
            self.bus.handle_timeout(50)

    def follow(self):
        path = list(zip(self.reply.path_x, self.reply.path_y, self.reply.path_z))
        while not self.robot or math.dist(path[-1][:2], self.robot.pos[:2]) > THERE:
            if self.bus.handle_timeout(100) <= 0 or not self.robot:
                continue
            distances = [math.dist(p[:2], self.robot.pos[:2]) for p in path]
            nearest = distances.index(min(distances))
            ahead = next((k for k in range(nearest, len(path)) if distances[k] >= AHEAD), len(path) - 1)
            target = self.robot
            target.pos = path[ahead]
            self.bus.publish("NAV_TARGET", target.encode())
            self.robot = None  # the next pose tells how far it has come


def main(argv):
    if len(argv) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    client = Client(lcm.LCM(*argv[2:3]), argv[1])
    client.ask()
    reply = client.reply
    if reply is None:
        print("no answer:", client.why, file=sys.stderr)
        return 2
    for answer in reply.answers:
        print(f"{100 * answer.probability:3.0f} %  {answer.reason}")
    print(reply.text, reply.goal_reason)
    if not reply.num_waypoints:
        return 1
    print(f"goal {reply.goal}, {reply.path_length:.1f} m to walk", flush=True)
    client.follow()
    print(f"there; the map has {len(client.things)} things")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
