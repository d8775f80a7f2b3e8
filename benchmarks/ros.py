"""An emitted node of ROS 2 beside a plant of ours: does it arrive, when does it stop, how late are its commands.

    build/ros/bin/python -m benchmarks ros SITE TASK RATE [--clock SPEED]

SITE: where the package of tasks/TASK.toml is installed. The plant, xdot = u or xddot = u, publishes its state RATE times a second
as the package's parameters say: an odometry that is turned, joint states, or an array. What happens to the node, in this order:
a state away from the start and a request to start; the start, and a second request; the mission; a state that is no number; no
state; the end of its process. --clock: the plant's clock is the node's, SPEED times as fast as ours, and leaps at the end.

Prints one JSON document: x at the prescribed time, u and what was said at each of these, the milliseconds from the last state
that was sent to a command (median, 99 %, most), and the same of how far apart commands are.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Accel, Twist
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger

ROOT = Path(__file__).resolve().parent.parent
CALM = 0.3  # seconds that each happening lasts
COMMANDS = {"twist": (Twist, "cmd_vel"), "accel": (Accel, "cmd_accel"), "array": (Float64MultiArray, "command")}
STATES = {"odometry": (Odometry, "odom"), "joints": (JointState, "joint_states"), "array": (Float64MultiArray, "state")}


class Plant(Node):
    """x, v in the world's frame. The body's heading is the third number where there is an odometry."""

    def __init__(self, task: dict[str, Any], rate: float, speed: float | None, state: str, command: str) -> None:
        super().__init__("plant")
        self.order = task.get("plant", {}).get("order", 1)
        self.axes, self.state, self.speed, self.period = task.get("axes", []), state, speed, 1 / rate
        self.x = [float(v) for v in task["initial_state"]]
        self.n = len(self.x)
        self.v, self.u = [0.0] * self.n, [0.0] * self.n
        self.away, self.bad, self.silent, self.stopped = 0.0, False, False, False
        self.now_, self.last, self.sent = 100.0, time.monotonic(), 0.0
        self.commands: list[tuple[float, float]] = []  # when, and how long after the state
        self.told: list[dict[str, str]] = []
        self.clock = self.create_publisher(Clock, "/clock", 10)
        kind, topic = STATES[state]
        self.out = self.create_publisher(kind, topic, qos_profile_sensor_data)
        kind, topic = COMMANDS[command]
        self.create_subscription(kind, topic, self.on_command, QoSProfile(depth=1))
        self.create_subscription(DiagnosticArray, "/diagnostics", self.on_told, QoSProfile(depth=10))
        self.create_timer(self.period / (speed or 1.0), self.on_tick)

    def turned(self, x: float, y: float, way: int) -> tuple[float, float]:
        heading = self.x[2] if self.state == "odometry" and self.n == 3 else 0.0
        c, s = math.cos(heading), way * math.sin(heading)
        return c * x - s * y, s * x + c * y

    def on_command(self, message: Any) -> None:
        now = time.monotonic()
        if isinstance(message, Float64MultiArray):
            self.u = list(message.data)
        else:
            x, y = self.turned(message.linear.x, message.linear.y, 1)
            self.u = [x, y, message.angular.z][: self.n]
        self.commands.append((now, now - self.sent))

    def on_told(self, message: DiagnosticArray) -> None:
        (status,) = message.status
        self.told.append({"message": status.message, **{v.key: v.value for v in status.values}})

    def on_tick(self) -> None:
        now = time.monotonic()
        passed, self.last = now - self.last, now
        if self.speed is not None:
            passed = self.period
            self.now_ += passed
            self.clock.publish(Clock(clock=Time(nanoseconds=round(self.now_ * 1e9)).to_msg()))
        if not self.stopped:
            if self.order == 2:
                self.x = [a + passed * (b + passed / 2 * c) for a, b, c in zip(self.x, self.v, self.u, strict=True)]
                self.v = [a + passed * b for a, b in zip(self.v, self.u, strict=True)]
            else:
                self.x = [a + passed * b for a, b in zip(self.x, self.u, strict=True)]
        if not self.silent:
            self.out.publish(self.message())
            self.sent = time.monotonic()

    def message(self) -> Any:
        x = [self.x[0] + self.away, *self.x[1:]] if not self.bad else [math.nan] * self.n
        stamp = self.get_clock().now().to_msg() if self.speed is None else Time(nanoseconds=round(self.now_ * 1e9)).to_msg()
        if self.state == "array":
            return Float64MultiArray(data=[*x, *(self.v if self.order == 2 else [])])
        if self.state == "joints":
            made = JointState(name=self.axes[::-1], position=x[::-1], velocity=self.v[::-1])
            made.header.stamp = stamp
            return made
        made = Odometry()
        made.header.stamp, made.header.frame_id, made.child_frame_id = stamp, "odom", "base_link"
        made.pose.pose.position.x, made.pose.pose.position.y = x[0], x[1]
        heading = x[2] if self.n == 3 else 0.0
        made.pose.pose.orientation.z, made.pose.pose.orientation.w = math.sin(heading / 2), math.cos(heading / 2)
        made.twist.twist.linear.x, made.twist.twist.linear.y = self.turned(self.v[0], self.v[1], -1)
        made.twist.twist.angular.z = self.v[2] if self.n == 3 else 0.0
        return made


class Trial:
    """What happens to the node and what is found then. fast: seconds of the plant's clock in one of ours."""

    def __init__(self, plant: Plant, name: str, fast: float) -> None:
        self.plant, self.fast, self.found = plant, fast, dict[str, Any]()
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(plant)
        self.start, self.stop = (plant.create_client(Trigger, f"/{name}/{service}") for service in ("start", "stop"))
        for client in (self.start, self.stop):
            while not client.wait_for_service(timeout_sec=0.1):
                self.executor.spin_once(timeout_sec=0.01)

    def spin(self, seconds: float) -> None:
        end = time.monotonic() + seconds / self.fast
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)

    def asks(self, name: str, client: Any) -> None:
        answer = client.call_async(Trigger.Request())
        while not answer.done():
            self.executor.spin_once(timeout_sec=0.01)
        self.found[name] = str(answer.result().message)

    def happens(self, name: str, seconds: float = CALM) -> None:
        plant, before = self.plant, len(self.plant.commands)
        self.spin(seconds)
        self.found[name] = {"u": list(plant.u), "commands": len(plant.commands) - before, "x": list(plant.x)}
        self.found[name] |= plant.told[-1] if plant.told else {}

    def mission(self, seconds: float) -> None:
        plant = self.plant
        plant.away = 50.0
        self.happens("before")
        self.asks("refused", self.start)
        plant.away = 0.0
        self.spin(CALM)
        self.asks("started", self.start)
        plant.commands.clear()
        plant.told.clear()
        self.happens("first", 0.5)
        self.asks("again", self.start)
        self.happens("arrived", seconds - 0.5)
        commands, told = list(plant.commands), list(plant.told)
        self.found["ms after a state"] = spread([1e3 * late for _, late in commands])
        self.found["ms apart"] = spread([1e3 * (b[0] - a[0]) for a, b in pairwise(commands)])
        self.found["commands"] = len(commands)
        self.found["outside"] = sum(one["status"] == "1" for one in told)
        self.found["least margin"] = min((float(one["margin"]) for one in told if one["margin"] != "None"), default=None)

    def trouble(self) -> None:
        plant = self.plant
        plant.bad = True
        self.happens("no number")
        plant.bad = False
        self.happens("a number")
        plant.silent = True
        self.happens("no state", 1.0)
        plant.silent = False
        self.happens("a state")
        if plant.speed is not None:
            plant.now_ -= 30.0
            self.happens("leap", 1.0)
        else:
            self.asks("stop", self.stop)
            self.happens("stopped", 1.0)
            self.found["v"] = list(plant.v)

    def end(self, node: subprocess.Popen[bytes]) -> None:
        plant = self.plant
        plant.u = [1.0] * plant.n
        plant.stopped = True  # what matters is the last command
        node.send_signal(signal.SIGINT)
        deadline = time.monotonic() + 5
        while node.poll() is None and time.monotonic() < deadline:
            self.executor.spin_once(timeout_sec=0.02)
        self.spin(CALM)
        self.found["ended"] = {"u": list(plant.u), "code": node.poll()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("site", type=Path)
    parser.add_argument("task")
    parser.add_argument("rate", type=float)
    parser.add_argument("--clock", type=float)
    asked = parser.parse_args()
    task = tomllib.loads((ROOT / "tasks" / f"{asked.task}.toml").read_text())
    package = f"{asked.task}_ros2"
    config = asked.site / "share" / package / "config" / f"{asked.task}.yaml"
    given = dict(line.split("#")[0].strip().split(": ", 1) for line in config.read_text().splitlines() if ": " in line)
    os.environ["ROS_DOMAIN_ID"] = str(random.randrange(1, 100))
    run = [sys.executable, "-c", f"from {package}.node import main; raise SystemExit(main())", "--ros-args"]
    run += ["--params-file", str(config), "-p", f"use_sim_time:={asked.clock is not None}"]
    node = subprocess.Popen(run, env={**os.environ, "PYTHONPATH": str(asked.site)})
    try:
        rclpy.init()
        plant = Plant(task, asked.rate, asked.clock, given["state"].strip(), given["command"].strip())
        trial = Trial(plant, asked.task, asked.clock or 1.0)
        trial.mission(float(task["prescribed_time"]))
        trial.trouble()
        trial.end(node)
    finally:
        node.terminate()
        node.wait()
    print(json.dumps(trial.found))
    trial.executor.shutdown()
    rclpy.try_shutdown()


def spread(values: list[float]) -> list[float]:
    """Median, 99 % and most."""
    ordered = sorted(values)
    at: Callable[[float], float] = lambda q: ordered[min(len(ordered) - 1, int(q * len(ordered)))]  # noqa: E731
    return [round(at(q), 3) for q in (0.5, 0.99, 1.0)]


if __name__ == "__main__":
    main()
