// The machine as a session moves it: limits before every command, touches looked at again. What is above may be a journal.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "devices/decorators/limited_device.h"
#include "devices/decorators/multi_touch_device.h"
#include "devices/machine.h"
#include "devices/session/machine_settings.h"
#include "devices/session/pausing_device.h"

namespace palpate {

class GuardedMachine {
public:
    // `pause` waits for the end of a pause that `stop` asks for; empty: nobody asks for one. REQUIRES: a machine. Throws
    // std::invalid_argument on settings out of range.
    GuardedMachine(std::unique_ptr<Machine> machine, const MachineSettings& settings, StopToken stop = {}, std::function<void()> pause = {})
        : machine_(std::move(machine)),
          pausing_(*machine_, std::move(stop), std::move(pause)),
          limited_(pausing_, settings.limits, settings.motion.resolution_mm),
          touching_(limited_, settings.touch, settings.motion.retract_mm) {}

    [[nodiscard]] Machine& machine() { return *machine_; }
    [[nodiscard]] ProbeDevice& device() { return touching_; }

private:
    std::unique_ptr<Machine> machine_;
    PausingDevice pausing_;
    LimitedDevice limited_;
    MultiTouchDevice touching_;
};

}  // namespace palpate
