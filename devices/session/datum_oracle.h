// The planner's oracle on a machine that drifts: visits to the datum between two questions, and what was touched put right in the end.
#pragma once

#include <vector>

#include "devices/session/datum_device.h"
#include "planner/probe_surface.h"
#include "planner/surface_oracle.h"

namespace palpate {

class DatumOracle final : public SurfaceOracle {
public:
    // `oracle` moves `device`; both must outlive this.
    DatumOracle(SurfaceOracle& oracle, DatumDevice& device) : oracle_(oracle), device_(device) {}

    [[nodiscard]] Point position() const override { return oracle_.position(); }
    void travel(std::span<const Point> path, Ground ground) override;
    [[nodiscard]] ProbeAnswer probe(const Point& target) override;
    [[nodiscard]] OracleTraits traits() const override { return oracle_.traits(); }
    [[nodiscard]] bool prove_alive() override { return oracle_.prove_alive(); }

    // Moves every touch, and the samples of the mesh, by what visits after it showed: the planner knew those before it only. Facets stay.
    void take_out_drift(Result& result) const;

private:
    struct Noted {
        Point touched = Point::Zero();  // as the planner was told
        Seconds time{0.0};
        Vector shift = Vector::Zero();  // mm: that this was reckoned with
    };

    SurfaceOracle& oracle_;
    DatumDevice& device_;
    std::vector<Noted> noted_;
};

}  // namespace palpate
