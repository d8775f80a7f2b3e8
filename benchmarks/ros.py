"""The crawler's node of ROS 2 beside a plant: does it arrive, how late are its commands.

    build/ros/bin/python benchmarks/ros.py SITE PERIOD STALE_AFTER

SITE: where the package crawler_ros2 is installed. The plant, xdot = u, publishes its state at the node's rate, then falls silent.
Prints one JSON document: x at t_c, u before the start and after the silence, the milliseconds from a state to the next command
(median, 99 %, most), and the same of how far apart commands are.
"""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
import time
from itertools import pairwise

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger

T_C = 6.0
SILENT = 0.5  # seconds


class Plant(Node):
    def __init__(self, period: float) -> None:
        super().__init__("plant")
        self.x, self.u, self.silent = [0.5, 0.5], [0.0, 0.0], False
        self.last, self.sent = time.monotonic(), 0.0
        self.commands: list[tuple[float, float]] = []  # when, and how long after the state
        self.told: list[tuple[int, str, str]] = []
        self.out = self.create_publisher(Float64MultiArray, "state", qos_profile_sensor_data)
        self.create_subscription(Float64MultiArray, "command", self.on_command, QoSProfile(depth=1))
        self.create_subscription(DiagnosticArray, "/diagnostics", self.on_told, QoSProfile(depth=10))
        self.create_timer(period, self.on_tick)

    def on_command(self, message: Float64MultiArray) -> None:
        now = time.monotonic()
        self.u = list(message.data)
        self.commands.append((now, now - self.sent))

    def on_told(self, message: DiagnosticArray) -> None:
        (status,) = message.status
        values = {v.key: v.value for v in status.values}
        self.told.append((status.level[0], status.message, values["status"]))

    def on_tick(self) -> None:
        now = time.monotonic()
        seconds, self.last = now - self.last, now
        self.x = [a + seconds * b for a, b in zip(self.x, self.u, strict=True)]
        if not self.silent:
            self.out.publish(Float64MultiArray(data=self.x))
            self.sent = now


def main() -> None:
    site, period, stale_after = sys.argv[1], float(sys.argv[2]), sys.argv[3]
    domain = str(random.randrange(1, 100))
    os.environ["ROS_DOMAIN_ID"] = domain
    command = "from crawler_ros2.node import main; main()"
    given = ["--ros-args", "-p", f"period:={period}", "-p", f"stale_after:={stale_after}"]
    node = subprocess.Popen([sys.executable, "-c", command, *given], env={**os.environ, "PYTHONPATH": site})
    rclpy.init()
    plant = Plant(period)
    executor = SingleThreadedExecutor()
    executor.add_node(plant)

    def spin(seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            executor.spin_once(timeout_sec=0.05)

    try:
        client = plant.create_client(Trigger, "/crawler/start")
        while not client.wait_for_service(timeout_sec=0.1):
            executor.spin_once(timeout_sec=0.01)
        spin(0.5)
        before = plant.u
        started = client.call_async(Trigger.Request())
        while not started.done():
            executor.spin_once(timeout_sec=0.01)
        plant.commands.clear()
        spin(T_C)
        arrived, commands, outside = plant.x, list(plant.commands), sum(status == "1" for _, _, status in plant.told)
        plant.silent = True
        spin(SILENT)
    finally:
        node.terminate()
        node.wait()
    apart = [1e3 * (b[0] - a[0]) for a, b in pairwise(commands)]
    late = [1e3 * seconds for _, seconds in commands]

    def spread(values: list[float]) -> list[float]:
        ordered = sorted(values)
        return [round(ordered[min(len(ordered) - 1, int(q * len(ordered)))], 3) for q in (0.5, 0.99, 1.0)]

    print(
        json.dumps(
            {
                "x": arrived, "before": list(before), "after": plant.u, "outside": outside, "message": plant.told[-1][1],
                "commands": len(commands), "ms after a state": spread(late), "ms apart": spread(apart),
            }
        )
    )  # fmt: skip
    executor.shutdown()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
