"""What tools/linuxcnc_bridge uses of LinuxCNC's Python module, and behaves as devices/FACTS.md, "Events", has it seen.

The machine hides a ball and stands at `start`. PALPATE_FAKE_LINUXCNC is JSON: `center` and `radius` of the ball, `start`, `servo` (s, of a cycle), `pace` (times as fast as real time), and what goes wrong: of what happens in mid-move, {"short": 2} is the second guarded move. What it
was told is written to PALPATE_FAKE_LOG, a line each, and what somebody does at the machine is read from there with .hand behind its name.
"""

import json
import math
import os
import time

version = "2.9 (fake)"
MODE_MANUAL, MODE_AUTO, MODE_MDI = 1, 2, 3
STATE_ESTOP, STATE_ESTOP_RESET, STATE_OFF, STATE_ON = 1, 2, 3, 4
INTERP_IDLE, INTERP_READING, INTERP_PAUSED, INTERP_WAITING = 1, 2, 3, 4
RCS_DONE, RCS_EXEC, RCS_ERROR = 1, 2, 3
NML_ERROR, OPERATOR_ERROR = 1, 11

wrong = json.loads(os.environ.get("PALPATE_FAKE_LINUXCNC", "{}"))
RADIUS, ACCELERATION, SERVO, PACE = wrong.get("radius", 20.0), wrong.get("acceleration", 1000.0), wrong.get("servo", 0.001), wrong.get("pace", 1.0)
CENTER, START = wrong.get("center", [0.0, 0.0, 0.0]), wrong.get("start", [0.0, 0.0, 40.0])


class error(Exception):
    pass


def log(text):
    with open(os.environ["PALPATE_FAKE_LOG"], "a") as file:
        file.write(text + "\n")


def dist(p):
    return math.sqrt(sum(x * x for x in p))


def from_center(p):
    return [x - c for x, c in zip(p, CENTER)]


class World:
    """Lengths are mm."""

    def __init__(self):
        self.position = list(START)
        self.homed = [not wrong.get("unhomed")] * 3
        self.homed_at = math.inf
        self.task_state = {"estop": STATE_ESTOP, "off": STATE_OFF}.get(wrong.get("state"), STATE_ON)
        self.task_mode, self.interp, self.rcs = MODE_MANUAL, INTERP_IDLE, RCS_DONE
        self.gcodes = {"units": 210, "distance": 900, "path": 640}
        self.feed_override = True
        self.is_teleop = True
        self.move, self.moves = None, 0
        self.tripped, self.probed = False, [0.0] * 3
        self.pressed = self.flips_at = None
        self.texts, self.serial, self.echo = [], 0, 0
        self.queued, self.is_frozen, self.is_slow = 0, False, False

    def probe(self):
        return self.pressed if self.pressed is not None else dist(from_center(self.position)) < RADIUS

    def is_wrong(self, name):
        return wrong.get(name) == self.moves

    def say(self, text):
        self.texts.append((OPERATOR_ERROR, text))

    def hand(self):
        """What somebody does at the machine: PALPATE_FAKE_LOG.hand, a word, taken once."""
        path = os.environ["PALPATE_FAKE_LOG"] + ".hand"
        if not os.path.exists(path):
            return
        word = open(path).read().strip()
        if word == "where":
            with open(path + ".at", "w") as file:
                file.write(" ".join(map(repr, self.position)))
        os.remove(path)
        if word == "on":
            self.task_state = STATE_ON
        elif word == "estop":
            self.task_state = STATE_ESTOP
        elif word.startswith("place"):
            self.position = [float(x) for x in word.split()[1:]]
        elif word == "press":
            self.pressed = True
        elif word == "release":
            self.pressed = None
        elif word == "unhome":
            self.homed = [False] * 3
        elif word == "unhome 0":
            self.homed[0] = False
        elif word == "home":
            self.homed = [True] * 3
        elif word == "manual":
            self.task_mode = MODE_MANUAL
        elif word != "where":
            raise error("nobody does %r at a machine" % word)

    def begin(self, target, feed, until_open):
        self.moves += 1
        if self.is_wrong("never_begins"):
            return
        if self.is_wrong("closed_at_start"):
            self.pressed = True
        self.tripped, self.rcs = False, RCS_EXEC
        names = "XYZ"
        for axis in range(3):
            if abs(target[axis]) > 60:
                self.say("Probe move on line 0 would exceed %s's %s limit" % (names[axis], "positive" if target[axis] > 0 else "negative"))
                self.say("Probe move on line 0 would exceed joint %d's limit" % axis)
                self.rcs = RCS_ERROR
                return
        if self.is_wrong("error"):
            self.rcs = RCS_ERROR
            if not wrong.get("mute"):
                self.say("joint 1 following error")
            return
        start = list(self.position)
        if self.probe() != until_open:  # already as it has to become
            self.rcs, self.tripped, self.probed = RCS_DONE, True, start
            return
        way = [b - a for a, b in zip(start, target)]
        length = dist(way)
        unit = [w / length for w in way] if length else way
        b, c = sum(u * s for u, s in zip(unit, from_center(start))), dist(from_center(start)) ** 2 - RADIUS**2
        touch = math.inf
        if b * b >= c:
            root = math.sqrt(b * b - c)
            touch = min([s for s in (-b - root, -b + root) if s >= 0 and (s == -b + root) == until_open], default=math.inf)
        seen = math.ceil(touch / feed / SERVO) * SERVO * feed if touch < length else math.inf
        self.move = dict(start=start, unit=unit, length=length, feed=feed, seen=seen, begun=time.monotonic(), target=list(target))

    def advance(self):
        self.hand()
        now = time.monotonic()
        if now > self.homed_at:
            self.homed, self.homed_at = [True] * 3, math.inf
        move = self.move
        if not move or self.is_slow:
            return
        gone = move["feed"] * PACE * (now - move["begun"])
        rest = gone
        if gone >= min(move["seen"], move["length"]):
            rest = move["length"]
            if move["seen"] < move["length"]:
                rest = min(move["length"], move["seen"] + move["feed"] ** 2 / (2 * ACCELERATION) + 2 * SERVO * move["feed"])
        self.position = [s + u * min(rest, move["length"]) for s, u in zip(move["start"], move["unit"])]
        if gone > move["length"] / 4 and self.suffer():
            return
        if rest == gone:
            return
        self.move, self.rcs = None, RCS_DONE
        if move["seen"] < move["length"]:
            self.tripped = not self.is_wrong("no_latch")
            self.probed = [s + u * move["seen"] for s, u in zip(move["start"], move["unit"])]
            if self.is_wrong("beside"):
                self.probed[0] += 3
            if self.is_wrong("bounce"):
                self.say("Probe tripped during non-probe move.")
                self.rcs = RCS_ERROR

    def suffer(self):
        """What comes from elsewhere in mid-move; True if it ends it."""
        if self.is_wrong("estop_in_move") or self.is_wrong("off_in_move"):
            self.task_state = STATE_ESTOP if self.is_wrong("estop_in_move") else STATE_OFF
            self.rcs = RCS_DONE  # and nothing is said
        elif self.is_wrong("manual_in_move"):
            self.task_mode, self.rcs = MODE_AUTO, RCS_DONE
        elif self.is_wrong("short"):
            self.rcs = RCS_DONE
        elif self.is_wrong("pause_in_move"):
            self.interp, self.is_slow = INTERP_PAUSED, True
            return True
        elif self.is_wrong("held") or self.is_wrong("motion_died"):
            self.is_slow = True
            return True
        elif self.is_wrong("task_died"):
            self.is_frozen = True
            return True
        elif self.is_wrong("second_mdi"):
            self.queued = 1
            return False
        else:
            return False
        self.move = None
        return True

    def take(self, text):
        """A command, echoed unless the task is dead."""
        log(text)
        self.serial += 1
        if self.is_frozen:
            time.sleep(1.0)  # five there
        else:
            self.advance()
            self.echo = self.serial


world = World()


class stat:
    ini_filename = "fake.ini"
    joints, spindles, cycle_time = 3, 1, 0.001

    def poll(self):
        if os.path.exists(os.environ["PALPATE_FAKE_LOG"] + ".gone"):
            raise error("emcStatusBuffer invalid err=3")
        w = world
        if w.is_frozen:
            return
        w.advance()
        units = self.linear_units = 1 / 25.4 if wrong.get("inch") else 1.0
        self.position = [x * units for x in w.position] + [0.0] * 6
        self.probed_position = [x * units for x in w.probed] + [0.0] * 6
        self.axis = [dict(min_position_limit=-60.0 * units, max_position_limit=60.0 * units)] * 3
        self.joint = [dict(homing=w.homed_at < math.inf, fault=bool(wrong.get("joint_fault")), min_hard_limit=0, max_hard_limit=0)] * 3
        self.homed = list(w.homed)
        self.task_state, self.task_mode, self.interp_state, self.state = w.task_state, w.task_mode, w.interp, w.rcs
        self.enabled = w.task_state == STATE_ON
        self.inpos = w.move is None
        self.queue = 0 if w.move is None else 1
        self.paused = self.task_paused = False
        self.queued_mdi_commands = w.queued
        self.current_vel = 0.0 if w.move is None else w.move["feed"]
        self.probe_val, self.probe_tripped = int(w.probe()), w.tripped
        self.gcodes = [0, 383, -1, 170, 400, w.gcodes["units"], w.gcodes["distance"], 940, 540, 490, 990, w.gcodes["path"], -1, 970, 911, 80]
        self.settings = [0.0, 600.0, 0.0, 0.05, 0.0]
        self.feed_override_enabled, self.adaptive_feed_enabled = w.feed_override, False
        shift = lambda name: [0.0, 0.0, 10.0 * units if wrong.get(name) else 0.0]
        self.g5x_index, self.g5x_offset = 1, shift("g54")
        self.g92_offset, self.tool_offset = shift("g92"), shift("tool")
        self.rotation_xy = 5.0 if wrong.get("rotation") else 0.0
        self.spindle = [dict(enabled=bool(wrong.get("spindle")), speed=1000.0)]
        self.mist, self.flood = bool(wrong.get("mist")), False
        self.echo_serial_number = w.echo


class command:
    @property
    def serial(self):
        return world.serial

    def mode(self, mode):
        world.take("mode %d" % mode)
        if not wrong.get("no_mdi"):
            world.task_mode = mode

    def teleop_enable(self, on):
        world.take("teleop_enable %d" % on)
        world.is_teleop = bool(on)

    def unhome(self, joint):
        world.take("unhome")
        world.homed = [False] * 3

    def home(self, joint):
        world.take("home")
        if world.task_mode != MODE_MANUAL:
            world.say("can't do that (EMC_JOINT_HOME:123) in MDI mode")
        elif world.is_teleop or all(world.homed):
            world.say("must be in joint mode to home")
        elif wrong.get("home_fails"):
            world.say("joint 0 home switch not found")
        else:
            world.homed_at = time.monotonic() + 0.15

    def abort(self):
        world.take("abort")
        if not world.is_frozen:
            time.sleep(0.04)
            world.advance()
            world.move, world.rcs, world.queued, world.is_slow = None, RCS_DONE, 0, wrong.get("motion_died") is not None and world.is_slow
            world.interp = INTERP_IDLE

    def mdi(self, text):
        world.take("mdi " + text)
        if world.is_frozen:
            return
        w = world
        if w.task_state != STATE_ON or not all(w.homed) or w.task_mode != MODE_MDI:
            w.say("Must be in MDI mode to issue MDI command")
            w.rcs = RCS_ERROR
            return
        words = text.split()
        if words[0].startswith("G38"):
            units = 25.4 if w.gcodes["units"] == 200 else 1.0
            target = [float(word[1:]) * units for word in words[1:4]]
            w.begin(target, float(words[4][1:]) * units / 60, words[0] == "G38.5")
            return
        for word in words:
            for name, codes in (("units", ("G20", "G21")), ("distance", ("G90", "G91")), ("path", ("G61", "G64"))):
                if word in codes and not (name == "path" and wrong.get("keeps_path")):
                    w.gcodes[name] = int(word[1:]) * 10
            if word in ("M48", "M49"):
                w.feed_override = word == "M48"
        w.rcs = RCS_DONE


class error_channel:
    def poll(self):
        return world.texts.pop(0) if world.texts else None


class ini:
    def __init__(self, path):
        units = 1 / 25.4 if wrong.get("inch") else 1.0
        self.values = {("EMC", "MACHINE"): "fake", ("EMCMOT", "SERVO_PERIOD"): "1000000", ("TRAJ", "MAX_LINEAR_VELOCITY"): "%r" % (400 * units)}
        for axis in "XYZ":
            self.values["AXIS_" + axis, "MAX_VELOCITY"] = "%r" % (500 * units)
            self.values["AXIS_" + axis, "MAX_ACCELERATION"] = "%r" % (ACCELERATION * units)

    def find(self, section, name):
        return self.values.get((section, name))
