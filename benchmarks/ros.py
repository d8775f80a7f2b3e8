"""Run an emitted node of ROS 2 with a simulated plant: whether it arrives, when it stops, and how fast it answers.

    build/ros/bin/python -m benchmarks ros SITE TASK RATE [--clock SPEED]

SITE: where the package of tasks/TASK.toml is installed. The plant, xdot = u or xddot = u, publishes its state RATE times a second
as the package's parameters say: odometry in the body's frame, joint states, or an array. The node meets these events, in order:
a request to start away from the start; a request at the start, and a second one; the mission; states that are not a number; no
state; the end of its process. --clock: the plant publishes the node's clock, SPEED times as fast as real time, and sets it back
at the end. tests/record/test_ros2.py runs this file, and reads the JSON document that it prints.

The document has, by event, x, u and what the node said, and for the mission the milliseconds from the last state to a command and
from one command to the next (median, 99 %, maximum).
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
EVENT_SECONDS = 0.3  # how long an event is observed
COMMANDS = {"twist": (Twist, "cmd_vel"), "accel": (Accel, "cmd_accel"), "array": (Float64MultiArray, "command")}
STATES = {"odometry": (Odometry, "odom"), "joints": (JointState, "joint_states"), "array": (Float64MultiArray, "state")}


class SimulatedPlant(Node):
    """A plant that publishes its state, takes the node's commands, and records them with the node's diagnostics.

    x and v are in the world's frame; of odometry the third number is the heading. rate: states per second. clock_speed: of the
    clock that the plant publishes, None where the node has the real one. state, command: keys of STATES and COMMANDS.
    """

    def __init__(self, task: dict[str, Any], rate: float, clock_speed: float | None, state: str, command: str) -> None:
        super().__init__("plant")
        self.order = task.get("plant", {}).get("order", 1)
        self.axes, self.state, self.clock_speed, self.period = task.get("axes", []), state, clock_speed, 1 / rate
        self.x = [float(v) for v in task["initial_state"]]
        self.n = len(self.x)
        self.v, self.u = [0.0] * self.n, [0.0] * self.n
        self.offset = 0.0  # of the first number of the state that is published
        self.sends_nan = self.is_silent = self.stands_still = False
        self.plant_time, self.last_tick, self.last_sent = 100.0, time.monotonic(), 0.0
        self.commands: list[tuple[float, float]] = []  # time, and seconds since the last state was sent
        self.reports: list[dict[str, str]] = []  # of the node, on /diagnostics
        self.clock_publisher = self.create_publisher(Clock, "/clock", 10)
        kind, topic = STATES[state]
        self.state_publisher = self.create_publisher(kind, topic, qos_profile_sensor_data)
        kind, topic = COMMANDS[command]
        self.create_subscription(kind, topic, self.on_command, QoSProfile(depth=1))
        self.create_subscription(DiagnosticArray, "/diagnostics", self.on_diagnostics, QoSProfile(depth=10))
        self.create_timer(self.period / (clock_speed or 1.0), self.on_tick)

    def rotated(self, x: float, y: float, sign: int) -> tuple[float, float]:
        """Return the vector turned by the heading: from the body's frame to the world's (sign 1), or back (-1)."""
        heading = self.x[2] if self.state == "odometry" and self.n == 3 else 0.0
        c, s = math.cos(heading), sign * math.sin(heading)
        return c * x - s * y, s * x + c * y

    def on_command(self, message: Any) -> None:
        now = time.monotonic()
        if isinstance(message, Float64MultiArray):
            self.u = list(message.data)
        else:
            x, y = self.rotated(message.linear.x, message.linear.y, 1)
            self.u = [x, y, message.angular.z][: self.n]
        self.commands.append((now, now - self.last_sent))

    def on_diagnostics(self, message: DiagnosticArray) -> None:
        (status,) = message.status
        self.reports.append({"message": status.message, **{v.key: v.value for v in status.values}})

    def on_tick(self) -> None:
        """Advance the clock and the state by the time that has passed, and publish them."""
        now = time.monotonic()
        elapsed, self.last_tick = now - self.last_tick, now
        if self.clock_speed is not None:
            elapsed = self.period
            self.plant_time += elapsed
            self.clock_publisher.publish(Clock(clock=Time(nanoseconds=round(self.plant_time * 1e9)).to_msg()))
        if not self.stands_still:
            if self.order == 2:
                self.x = [a + elapsed * (b + elapsed / 2 * c) for a, b, c in zip(self.x, self.v, self.u, strict=True)]
                self.v = [a + elapsed * b for a, b in zip(self.v, self.u, strict=True)]
            else:
                self.x = [a + elapsed * b for a, b in zip(self.x, self.u, strict=True)]
        if not self.is_silent:
            self.state_publisher.publish(self.state_message())
            self.last_sent = time.monotonic()

    def state_message(self) -> Any:
        """Return the state as a message of the kind that the node reads."""
        x = [self.x[0] + self.offset, *self.x[1:]] if not self.sends_nan else [math.nan] * self.n
        now = self.get_clock().now() if self.clock_speed is None else Time(nanoseconds=round(self.plant_time * 1e9))
        stamp = now.to_msg()
        if self.state == "array":
            return Float64MultiArray(data=[*x, *(self.v if self.order == 2 else [])])
        if self.state == "joints":
            joints = JointState(name=self.axes[::-1], position=x[::-1], velocity=self.v[::-1])
            joints.header.stamp = stamp
            return joints
        odometry = Odometry()
        odometry.header.stamp, odometry.header.frame_id, odometry.child_frame_id = stamp, "odom", "base_link"
        odometry.pose.pose.position.x, odometry.pose.pose.position.y = x[0], x[1]
        heading = x[2] if self.n == 3 else 0.0
        odometry.pose.pose.orientation.z, odometry.pose.pose.orientation.w = math.sin(heading / 2), math.cos(heading / 2)
        odometry.twist.twist.linear.x, odometry.twist.twist.linear.y = self.rotated(self.v[0], self.v[1], -1)
        odometry.twist.twist.angular.z = self.v[2] if self.n == 3 else 0.0
        return odometry


class NodeTrial:
    """The events that the node meets, and `results`, by event. clock_speed: seconds of the plant's clock per real second."""

    def __init__(self, plant: SimulatedPlant, name: str, clock_speed: float) -> None:
        self.plant, self.clock_speed, self.results = plant, clock_speed, dict[str, Any]()
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(plant)
        self.start, self.stop = (plant.create_client(Trigger, f"/{name}/{service}") for service in ("start", "stop"))
        for client in (self.start, self.stop):
            while not client.wait_for_service(timeout_sec=0.1):
                self.executor.spin_once(timeout_sec=0.01)

    def spin(self, seconds: float) -> None:
        """Let plant and node run for so many seconds of the plant's clock."""
        end = time.monotonic() + seconds / self.clock_speed
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)

    def call_service(self, name: str, client: Any) -> None:
        """Call the node's service, and keep its answer."""
        answer = client.call_async(Trigger.Request())
        while not answer.done():
            self.executor.spin_once(timeout_sec=0.01)
        self.results[name] = str(answer.result().message)

    def observe(self, name: str, seconds: float = EVENT_SECONDS) -> None:
        """Let an event last, then keep u, x, the number of commands and the node's last report."""
        plant, before = self.plant, len(self.plant.commands)
        self.spin(seconds)
        self.results[name] = {"u": list(plant.u), "commands": len(plant.commands) - before, "x": list(plant.x)}
        self.results[name] |= plant.reports[-1] if plant.reports else {}

    def run_mission(self, seconds: float) -> None:
        """Ask for a start, first away from the start set, and observe the mission. seconds: the prescribed time."""
        plant = self.plant
        plant.offset = 50.0
        self.observe("before")
        self.call_service("refused", self.start)
        plant.offset = 0.0
        self.spin(EVENT_SECONDS)
        self.call_service("started", self.start)
        plant.commands.clear()
        plant.reports.clear()
        self.observe("first", 0.5)
        self.call_service("again", self.start)
        self.observe("arrived", seconds - 0.5)
        commands, reports = list(plant.commands), list(plant.reports)
        self.results["ms after a state"] = quantiles([1e3 * delay for _, delay in commands])
        self.results["ms apart"] = quantiles([1e3 * (b[0] - a[0]) for a, b in pairwise(commands)])
        self.results["commands"] = len(commands)
        self.results["outside"] = sum(report["status"] == "1" for report in reports)
        margins = [float(report["margin"]) for report in reports if report["margin"] != "None"]
        self.results["least margin"] = min(margins, default=None)

    def run_disturbances(self) -> None:
        """Observe the node without a proper state, and after its clock is set back or it is asked to stop."""
        plant = self.plant
        plant.sends_nan = True
        self.observe("no number")
        plant.sends_nan = False
        self.observe("a number")
        plant.is_silent = True
        self.observe("no state", 1.0)
        plant.is_silent = False
        self.observe("a state")
        if plant.clock_speed is not None:
            plant.plant_time -= 30.0
            self.observe("leap", 1.0)
        else:
            self.call_service("stop", self.stop)
            self.observe("stopped", 1.0)
            self.results["v"] = list(plant.v)

    def interrupt(self, node: subprocess.Popen[bytes]) -> None:
        """End the node's process by SIGINT, and keep its last command and its exit code."""
        plant = self.plant
        plant.u = [1.0] * plant.n
        plant.stands_still = True  # only the node's last command is of interest
        node.send_signal(signal.SIGINT)
        deadline = time.monotonic() + 5
        while node.poll() is None and time.monotonic() < deadline:
            self.executor.spin_once(timeout_sec=0.02)
        self.spin(EVENT_SECONDS)
        self.results["ended"] = {"u": list(plant.u), "code": node.poll()}


def main() -> None:
    """Start the node, run all events with it, and print the results as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("site", type=Path)
    parser.add_argument("task")
    parser.add_argument("rate", type=float)
    parser.add_argument("--clock", type=float)
    options = parser.parse_args()
    task = tomllib.loads((ROOT / "tasks" / f"{options.task}.toml").read_text())
    package = f"{options.task}_ros2"
    config = options.site / "share" / package / "config" / f"{options.task}.yaml"
    parameters = dict(line.split("#")[0].strip().split(": ", 1) for line in config.read_text().splitlines() if ": " in line)
    os.environ["ROS_DOMAIN_ID"] = str(random.randrange(1, 100))
    run = [sys.executable, "-c", f"from {package}.node import main; raise SystemExit(main())", "--ros-args"]
    run += ["--params-file", str(config), "-p", f"use_sim_time:={options.clock is not None}"]
    node = subprocess.Popen(run, env={**os.environ, "PYTHONPATH": str(options.site)})
    try:
        rclpy.init()
        state, command = parameters["state"].strip(), parameters["command"].strip()
        plant = SimulatedPlant(task, options.rate, options.clock, state, command)
        trial = NodeTrial(plant, options.task, options.clock or 1.0)
        trial.run_mission(float(task["prescribed_time"]))
        trial.run_disturbances()
        trial.interrupt(node)
    finally:
        node.terminate()
        node.wait()
    print(json.dumps(trial.results))
    trial.executor.shutdown()
    rclpy.try_shutdown()


def quantiles(values: list[float]) -> list[float]:
    """Return the median, the value that 99 % do not exceed, and the maximum."""
    ordered = sorted(values)
    at: Callable[[float], float] = lambda q: ordered[min(len(ordered) - 1, int(q * len(ordered)))]  # noqa: E731
    return [round(at(q), 3) for q in (0.5, 0.99, 1.0)]


if __name__ == "__main__":
    main()
