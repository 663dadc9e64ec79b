#!/usr/bin/env python3
"""What waits at the change of shift: machines hand in the sessions of a shift within a few minutes, one writer takes them one after the other.

tests/scale/shift_change.py MACHINES SESSIONS SERVICE_S WINDOW_S [SEED]: one line of numbers; --check: its test.
A session that was handed in waits with its cell (docs/cell.md) until the service takes it; it is taken when it is durable.
"""
import dataclasses
import random
import sys


@dataclasses.dataclass(frozen=True)
class Outcome:
    longest_queue: int  # sessions that wait or are being taken
    p50_s: float  # from handing in to durable
    p99_s: float
    all_taken_s: float  # after the first one could be handed in


def simulate(arrivals_s: "list[float]", service_s: float) -> Outcome:
    """Sessions that are handed in at those times, each of which keeps the writer for `service_s`."""
    free_s, waits_s, ends_s = 0.0, [], []
    longest, ended = 0, 0
    for number, at_s in enumerate(sorted(arrivals_s), 1):
        free_s = max(free_s, at_s) + service_s
        ends_s.append(free_s)
        waits_s.append(free_s - at_s)
        while ended < len(ends_s) and ends_s[ended] <= at_s:
            ended += 1
        longest = max(longest, number - ended)
    waits_s.sort()
    return Outcome(longest, waits_s[len(waits_s) // 2], waits_s[int(0.99 * (len(waits_s) - 1))], free_s)


def shift_change(machines: int, sessions: int, service_s: float, window_s: float, seed: int = 26) -> Outcome:
    """Each machine hands in its sessions at once, at a moment of the window of its own."""
    chance = random.Random(seed)
    arrivals_s = []
    for _ in range(machines):
        arrivals_s += [chance.uniform(0.0, window_s)] * sessions
    return simulate(arrivals_s, service_s)


def check() -> None:
    """Where there is a formula, the simulation gives what it says."""
    # All at once: the k-th of n waits k service times.
    at_once = simulate([0.0] * 1000, 0.5)
    assert at_once.longest_queue == 1000 and at_once.all_taken_s == 500.0 and abs(at_once.p50_s - 250.0) <= 0.5, at_once
    # Slower than they are taken: nobody waits for another.
    alone = simulate([2.0 * k for k in range(1000)], 0.5)
    assert alone.longest_queue == 1 and alone.p99_s == 0.5 and alone.all_taken_s == 1998.5, alone
    # Poisson arrivals at a constant service time, half of what is possible (M/D/1): the mean number there is rho + rho^2 / 2 / (1 - rho),
    # by Little's law the mean time is that over the rate. 200,000 of them: the mean's own standard deviation is below 1 %.
    chance, at_s, service_s, rho = random.Random(1), 0.0, 0.5, 0.5
    arrivals_s = []
    for _ in range(200_000):
        at_s += chance.expovariate(rho / service_s)
        arrivals_s.append(at_s)
    free_s = total_s = 0.0
    for at_s in arrivals_s:
        free_s = max(free_s, at_s) + service_s
        total_s += free_s - at_s
    expected_s = (rho + rho * rho / 2 / (1 - rho)) / (rho / service_s)
    assert abs(total_s / len(arrivals_s) / expected_s - 1) < 0.03, (total_s / len(arrivals_s), expected_s)
    assert abs(simulate(arrivals_s, service_s).all_taken_s - free_s) < 1e-6
    # More than the window can take: the last is taken when all service times are over, whatever the order of arrival.
    burst = shift_change(1000, 3, 1.0, 600.0)
    assert 3000.0 <= burst.all_taken_s <= 3000.0 + 60.0 and burst.longest_queue > 2000, burst
    print("the simulation gives what formulas say")


if __name__ == "__main__":
    if sys.argv[1:] == ["--check"]:
        check()
    else:
        print(shift_change(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]), float(sys.argv[4]), *map(int, sys.argv[5:6])))
