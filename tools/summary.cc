#include "tools/summary.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "devices/version.h"
#include "planner/machine_time.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

// JSON knows no infinity: an unknown distance is null.
Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

void add_places(Json& json, const char* key, const std::vector<BadPlace>& places) {
    if (places.empty()) return;
    json[key] = Json::array();
    for (const BadPlace& place : places) {
        json[key].push_back({{"position", {place.position.x(), place.position.y(), place.position.z()}},
                             {"what", place.what},
                             {"epsilon_needed_below", place.epsilon_needed}});
    }
}

Json summarise(const Certificate& certificate, const std::vector<BadPlace>& bad_places, const std::vector<BadPlace>& thin_places) {
    Json json{{"status", to_string(certificate.status)}, {"statement", certificate.statement}, {"premises", Json::array()}};
    for (const Premise& p : certificate.premises) {
        json["premises"].push_back({{"name", name_of(p.kind)}, {"state", to_string(p.state)}, {"detail", p.detail}});
    }
    add_places(json, "bad_places", bad_places);
    add_places(json, "thin_places", thin_places);
    return json;
}

// Nothing where no object was named.
Json object_of(const Provenance& from) {
    if (!from.shape.empty()) return {{"shape", from.shape}};
    if (from.mesh.empty()) return nullptr;
    return {{"mesh", from.mesh}, {"sha256", from.object_sha256.empty() ? Json(nullptr) : Json(from.object_sha256)}};
}

Json summarise(const PartResult& part) {
    Json area;
    for (std::size_t tag = 0; tag < kPartTags; ++tag) area[name_of(static_cast<PartTag>(tag))] = part.report.area.at(tag);
    return {
        {"facets", part.topology.facets},
        {"components", part.topology.components},
        {"euler_characteristic", part.topology.euler_characteristic},
        {"boundary_edges", part.topology.boundary_edges},
        {"nonmanifold_edges", part.topology.nonmanifold_edges},
        {"crossing_facets", part.surface.crossings.size()},
        {"area", area},
        {"uncertainty",
         {{"median", part.report.uncertainty_median}, {"p95", part.report.uncertainty_95}, {"maximum", part.report.uncertainty_maximum}}}};
}

// What every run has, whatever answered it.
Json summarise(const Result& r, const std::optional<PartResult>& part, const Provenance& from, double epsilon, double planner_seconds,
               double oracle_seconds, double machine_estimate) {
    const Cost& a = r.cost;
    Json json{
        {"schema", 1},
        {"program", {{"name", "palpate"}, {"version", program_version()}}},
        {"configuration", {{"digest", from.config_digest}}},
        {"object", object_of(from)},
        {"samples", r.samples - r.known_samples},
        {"facets", r.topology.facets},
        {"components", r.topology.components},
        {"euler_characteristic", r.topology.euler_characteristic},
        {"boundary_edges", r.topology.boundary_edges},
        {"nonmanifold_edges", r.topology.nonmanifold_edges},
        {"epsilon", epsilon},
        {"max_ball_radius", r.max_ball_radius},
        {"max_plausible_ball_radius", r.max_plausible_ball_radius},
        {"probes",
         {{"total", a.probes()},
          {"contact", a.contact},
          {"clear", a.clear},
          {"failed", a.failed},
          {"grazes", a.grazes},
          {"inferred_contact", a.inferred_contact},
          {"plausible_contact", a.plausible_contact},
          {"inferred_clear", a.inferred_clear},
          {"seed", a.seed}}},
        {"displacement", {{"total", a.displacement()}, {"travel", a.travel}, {"probing", a.probing}}},
        {"lower_bounds",
         {{"samples", static_cast<std::uint64_t>(std::ceil(r.lower_bound_samples))}, {"displacement", r.lower_bound_displacement}}},
        {"complete", r.certificate.status != Certificate::Status::incomplete},
        {"certificate", summarise(r.certificate, r.bad_places, r.thin_places)},
        {"time", {{"planner", planner_seconds}, {"oracle", oracle_seconds}, {"machine_estimate", machine_estimate}}},
    };
    if (r.certificate.find(Premise::Kind::known_solids) != nullptr || !r.is_outside.empty()) json["virtual_contacts"] = r.known_samples;
    if (r.deviation) {
        const DeviationEvidence& d = *r.deviation;
        json["tolerance"] = {{"wanted", d.tolerance}, {"foretold", d.foretold}, {"unmet_facets", d.unmet_facets},
                             {"touched", d.touched},  {"audited", d.audited},   {"beyond", d.beyond},
                             {"barred", d.barred},    {"worst", d.worst},       {"scale", d.scale}};
        Json& reliability = json["tolerance"]["reliability"] = Json::array();
        for (const StatedDeviation& s : d.stated) {
            if (s.touched == 0) continue;
            reliability.push_back({{"stated_above", s.least}, {"touched", s.touched}, {"within", s.within}, {"worst", s.worst}});
            if (std::isfinite(s.most)) reliability.back()["stated_up_to"] = s.most;
        }
    }
    if (r.earlier) {
        const EarlierEvidence& e = *r.earlier;
        json["earlier"] = {{"touches", e.touches},       {"samples", e.samples}, {"checked", e.checked},
                           {"directions", e.directions}, {"limit", e.limit},     {"worst", e.worst}};
    }
    if (part) json["part"] = summarise(*part);
    return json;
}

// What the known places showed that resumed sessions touched again: over all of them the fewest directions and the largest offset.
Json datum_of(const std::vector<JournalResumption>& resumptions) {
    std::size_t touches = 0;
    int directions = 3;
    double largest = 0;
    for (const JournalResumption& r : resumptions) {
        touches += r.contacts.size();
        directions = std::min(directions, r.directions);
        for (const double offset : r.offsets_mm) largest = std::max(largest, std::abs(offset));
    }
    if (resumptions.empty()) return nullptr;
    return {{"touches", touches}, {"directions", directions}, {"largest_offset", largest}};
}

}  // namespace

const char* to_string(Premise::State state) {
    switch (state) {
        case Premise::State::checked:
            return "checked";
        case Premise::State::assumed:
            return "assumed";
        case Premise::State::refuted:
            return "refuted";
        case Premise::State::missing:
            return "missing";
    }
    return "";
}

const char* to_string(Certificate::Status status) {
    switch (status) {
        case Certificate::Status::certified:
            return "certified";
        case Certificate::Status::conditional:
            return "conditional";
        case Certificate::Status::refuted:
            return "refuted";
        case Certificate::Status::incomplete:
            return "incomplete";
    }
    return "";
}

nlohmann::ordered_json to_json(const ToolAccount& tool) {
    using Part = ToolContact::Part;
    using Met = ToolContact::Met;
    Json touches;
    for (const auto& [name, part] : {std::pair("ball", Part::ball), std::pair("stylus", Part::stylus), std::pair("holder", Part::holder)}) {
        touches[name] = {{"object", tool.touches(part, Met::object)}, {"fixture", tool.touches(part, Met::fixture)}};
    }
    return {{"moves_into_object", tool.moves_into_object}, {"moves_into_fixtures", tool.moves_into_fixtures}, {"touches", touches}};
}

std::string to_json(const Simulation& run, const std::optional<PartResult>& part, double epsilon, const Provenance& provenance) {
    Json json = summarise(run.result, part, provenance, epsilon, run.planner_seconds, run.oracle_seconds, run.machine_time.count());
    Json& truth = json["truth"] = Json::object();
    if (run.truth) {
        truth = {
            {"hausdorff", number(run.truth->hausdorff)},
            {"mean_distance", number(run.truth->mean_distance)},
            {"euler_characteristic", run.truth->euler_characteristic},
            {"components", run.truth->components},
            {"area", run.truth->area},
            {"reach", run.truth->reach ? number(*run.truth->reach) : Json(nullptr)},
            {"wrong_facets", std::ranges::count(run.verdicts, FacetVerdict::wrong)},
            {"flipped_facets", std::ranges::count(run.verdicts, FacetVerdict::flip)},
        };
    }
    if (run.curved_truth) {
        truth["surface"] = {
            {"p95", number(run.curved_truth->p95)}, {"p99", number(run.curved_truth->p99)}, {"max", number(run.curved_truth->max)}};
    }
    truth["wrong_inferences"] = run.wrong_inferences;
    truth["unsafe_moves"] = run.unsafe_moves;
    truth["moves"] = run.moves;
    truth["distance"] = run.distance;
    if (run.moves_out_of_area) truth["moves_out_of_area"] = *run.moves_out_of_area;
    if (run.tool) truth["tool"] = to_json(*run.tool);
    return json.dump(2) + '\n';
}

std::string to_json(const MachineRun& run, const std::optional<PartResult>& part, double epsilon, const Provenance& provenance) {
    const Meter& meter = run.meter;
    Json json = summarise(run.result, part, provenance, epsilon, run.planner_seconds, run.oracle_seconds, meter.machine_time.count());
    const auto moves = [](const MoveCount& count) {
        return Json{{"reached", count.reached}, {"contact", count.contact}, {"failed", count.failed}, {"vanished", count.vanished}};
    };
    const std::size_t misses = missed_touches(run.resumptions);
    json["machine"] = {
        {"identity", run.machine},
        {"moves", {{"travel", moves(meter.travel)}, {"probe", moves(meter.probe)}}},
        {"displacement", meter.displacement_mm},
        {"events",
         {{"spurious_trigger", meter.count(DeviceEvent::Kind::spurious_trigger)},
          {"scattered_touch", meter.count(DeviceEvent::Kind::scattered_touch)},
          {"repeated_command", meter.count(DeviceEvent::Kind::repeated_command)},
          {"reconnected", meter.count(DeviceEvent::Kind::reconnected)}}},
        {"grazes", run.grazes},
        {"resumptions", run.resumptions.size() - misses},
        {"missed_touches", misses},
        {"datum", datum_of(run.resumptions)},
    };
    if (run.drift) {
        const DriftAccount& drift = *run.drift;
        json["machine"]["drift"] = {{"visits", drift.visits},
                                    {"touches", drift.touches},
                                    {"way", drift.way_mm},
                                    {"directions", drift.directions},
                                    {"shift", {drift.shift.x(), drift.shift.y(), drift.shift.z()}},
                                    {"largest_shift", drift.largest_shift_mm},
                                    {"largest_change", drift.largest_change_mm}};
    }
    json["probes"]["checks"] = run.result.cost.checks;
    json["displacement"]["home"] = run.result.cost.home;
    return json.dump(2) + '\n';
}

}  // namespace palpate
