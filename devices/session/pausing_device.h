// Where a session rests for a while: at the start of a move, with the machine at a standstill.
#pragma once

#include <functional>

#include "devices/machine.h"
#include "devices/probe_device.h"
#include "devices/stop_request.h"

namespace palpate {

class PausingDevice final : public ProbeDevice {
public:
    // `wait` returns when the pause is over. `machine` must outlive this, and hear the same requests.
    PausingDevice(Machine& machine, StopToken stop, std::function<void()> wait)
        : machine_(machine), stop_(std::move(stop)), wait_(std::move(wait)) {}

    [[nodiscard]] Point position() const override { return machine_.device().position(); }
    // A move that a pause ended is made again afterwards. Throws PositionLost if the tool is elsewhere then.
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override;
    void stop() override { machine_.device().stop(); }

private:
    void pause();

    Machine& machine_;
    StopToken stop_;
    std::function<void()> wait_;
};

}  // namespace palpate
