#include <palpate/planner/probe_surface.h>

#include <cmath>
#include <cstdio>

using palpate::Point;

// A solid that can only be touched: an ellipsoid around the origin. Yours may be a machine, another library's mesh, a recording.
class Ellipsoid final : public palpate::SurfaceOracle {
public:
    Ellipsoid(const Point& semi_axes, const Point& start) : semi_axes_(semi_axes), tool_(start) {}

    Point position() const override { return tool_; }

    // The way was found free.
    void travel(std::span<const Point> path, palpate::Ground /*ground*/) override {
        if (!path.empty()) tool_ = path.back();
    }

    // Straight on until something is touched.
    palpate::ProbeAnswer probe(const Point& target) override {
        // Where the way goes into the ball that the ellipsoid is in units of its axes: |from + t · way| = 1.
        const Point from = tool_.cwiseQuotient(semi_axes_);
        const Point way = (target - tool_).cwiseQuotient(semi_axes_);
        const double a = way.squaredNorm(), b = from.dot(way), c = from.squaredNorm() - 1;
        const double t = (-b - std::sqrt(b * b - a * c)) / a;  // not a number where it does not
        if (t > -1e-12 && t <= 1) {                            // rounding: the tool may rest on the surface
            tool_ += t * (target - tool_);
            return {palpate::ProbeAnswer::Outcome::contact, tool_};
        }
        tool_ = target;
        return {palpate::ProbeAnswer::Outcome::clear, tool_};
    }

    // What is known beforehand: these touches are exact.
    palpate::OracleTraits traits() const override { return {}; }

private:
    Point semi_axes_;  // mm
    Point tool_;
};

int main() {
    Ellipsoid solid({1.2, 1.0, 0.8}, {0, 0, 3});
    const palpate::Region workspace(palpate::Ball{Point::Zero(), 1.5});  // the solid is in it, the tool starts outside
    palpate::Options options;
    options.epsilon = 0.08;           // mm: no ball around the mesh's triangles is larger
    options.reach = 0.8 * 0.8 / 1.2;  // mm: the least radius of curvature; leave it out if you cannot know
    const palpate::Result result = palpate::probe_surface(solid, workspace, options);

    std::printf("%zu samples, %zu triangles, %.0f mm of motion. %s\n", result.samples, result.mesh.triangles.size(),
                result.cost.displacement(), result.certificate.statement.c_str());
    const bool is_right = result.topology.is_closed_oriented_manifold() && result.topology.euler_characteristic == 2 &&
                          result.certificate.status == palpate::Certificate::Status::certified;
    return is_right ? 0 : 1;
}
