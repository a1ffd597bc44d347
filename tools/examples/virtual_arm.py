#!/usr/bin/env python3
"""A virtual arm that Palpate drives: a template for a program of your own (devices/external/PROTOCOL.md).

It moves a point probe around a ball that it hides (radius 20 mm, around 0, 0, 0). What to replace for a real arm is in class Arm.
Standard library only. Used as  machine: {external: {command: [python3, tools/examples/virtual_arm.py]}, ...}
"""
import json, math, select, sys, time

RADIUS = 20.0


class Arm:
    """A straight move at constant speed. A real arm moves by itself, and stops by itself when its probe changes."""

    def __init__(self):
        self.position, self.way, self.touched = [0.0, 0.0, 60.0], None, None

    def probe_closed(self):
        return math.dist(self.position, (0, 0, 0)) <= RADIUS

    def begin(self, to, feed, until):
        self.way = (list(self.position), to, feed, until, time.monotonic())
        self.touched = None

    def stop(self):
        """Stops it, and returns once it stands. This one stands at once; a real one is told to, and waited for."""
        self.way = None

    def step(self):
        """Goes on; True once it stands."""
        start, to, feed, until, begun = self.way
        length = math.dist(start, to)
        gone = min(feed * (time.monotonic() - begun), length)
        was = math.dist(start, self.position)
        while was < gone:  # in steps of 5 µm, so that the touch is found that exactly
            was = min(was + 0.005, gone)
            self.position = [a + (b - a) * was / length for a, b in zip(start, to)]
            if self.probe_closed() == (until == "closed"):
                self.touched = list(self.position)
                return True
        return gone >= length


def say(**line):
    print(json.dumps(line), flush=True)


def main():
    arm = Arm()
    try:
        talk(arm)
    finally:
        arm.stop()  # whatever ends this program: Palpate may be gone, and nobody watches


def talk(arm):
    move, silence, heard, told = None, 0.5, 0.0, 0.0
    probe = lambda: "closed" if arm.probe_closed() else "open"
    buffer = b""
    while True:
        ready = select.select([sys.stdin.buffer], [], [], 0.002 if move else 0.1)[0]
        if ready:
            part = sys.stdin.buffer.raw.read(4096)
            if not part:
                return  # Palpate is gone
            buffer += part
            heard = time.monotonic()
        while b"\n" in buffer:
            line, buffer = buffer.split(b"\n", 1)
            ask = json.loads(line)
            what, number = ask["ask"], ask.get("id")
            if what == "hello":
                silence = ask["silence"]
                say(id=number, name="Virtual arm in Python", limits={"min": [-100] * 3, "max": [100] * 3}, feed=500, acceleration=1000,
                    resolution=0.005, stops_at_touch=True, latches=True)
            elif what == "state":
                say(id=number, position=arm.position, moving=move is not None, probe=probe(), homed=True, fault="")
            elif what == "stop":
                arm.stop()
                if move:
                    say(id=move, ended="stopped", position=arm.position, probe=probe())
                    move = None
                say(id=number, position=arm.position, probe=probe())
            elif what in ("move_guarded", "travel"):
                if move or (arm.probe_closed() and ask["until"] == "closed") or max(map(abs, ask["to"])) > 100:
                    say(id=number, error="it moves" if move else "the probe is closed" if arm.probe_closed() else "beyond the limits")
                else:
                    arm.begin(ask["to"], ask["feed"], ask["until"])
                    move, told = number, time.monotonic()
        if move and time.monotonic() - heard > silence:
            return  # nobody watches
        if move and arm.step():
            touch = {"ended": "probe", "touched": arm.touched} if arm.touched else {"ended": "target"}
            say(id=move, position=arm.position, probe=probe(), **touch)
            move = None
        elif move and time.monotonic() - told > 0.08:
            told = time.monotonic()
            say(alive=True, position=arm.position)


if __name__ == "__main__":
    main()
