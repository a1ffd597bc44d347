#include "sim/machines/grbl/internal/grbl_report.h"

#include <fmt/format.h>

#include "devices/motion_model.h"

namespace palpate {
namespace {

std::string number(double value, int decimals) {
    const std::string text = fmt::format("{:.{}f}", value, decimals);
    // A count of steps has no negative zero.
    return text.find_first_not_of("-0.") == std::string::npos && text[0] == '-' ? text.substr(1) : text;
}

std::string coordinates(const Point& p, bool inches) {
    const double unit = inches ? kInch : 1.0;
    const int decimals = inches ? 4 : 3;
    return fmt::format("{},{},{}", number(p.x() / unit, decimals), number(p.y() / unit, decimals), number(p.z() / unit, decimals));
}

// In tenths: "G1", "G38.2".
std::string g_word(int tenths) {
    return tenths % 10 == 0 ? fmt::format("G{}", tenths / 10) : fmt::format("G{}.{}", tenths / 10, tenths % 10);
}

std::string running_letters(const GrblModal& modal) {
    std::string letters = modal.spindle == 3 ? "S" : modal.spindle == 4 ? "C" : "";
    if (modal.flood) letters += 'F';
    if (modal.mist) letters += 'M';
    return letters;
}

// Reports from one that tells a thing to the next, at rest and while moving (REPORT_WCO_REFRESH_..., REPORT_OVR_REFRESH_...).
constexpr int kOffsetAtRest = 10;
constexpr int kOffsetMoving = 30;
constexpr int kOverridesAtRest = 10;
constexpr int kOverridesMoving = 20;

}  // namespace

std::string GrblStatusReport::next(const GrblStatus& status, const GrblSettings& settings) {
    const GrblSettings::Reports reports = settings.reports();
    const bool hal = dialect_ == GrblDialect::grblhal;
    const bool inches = settings.inches();
    std::string text = fmt::format("<{}", status.state);
    if (reports.machine_position) {
        text += fmt::format("|MPos:{}", coordinates(status.position, inches));
    } else {
        text += fmt::format("|WPos:{}", coordinates(status.position - status.work_offset, inches));
    }
    if (reports.buffers) {
        text += fmt::format("|Bf:{},{}", status.planner_free, status.buffer_free);
    }
    text += fmt::format("|FS:{},0", number(status.speed_mm_per_s * kSecondsPerMinute / (inches ? kInch : 1.0), inches ? 1 : 0));
    if (!reports.pins) {
        // It does not say that it does not say.
    } else if (status.probe_closed) {
        text += "|Pn:P";
    } else if (hal && status.probe_cut) {
        text += "|Pn:O";
    }
    if (!reports.offset) {
        // Likewise.
    } else if (until_offset_ > 0) {
        --until_offset_;
    } else {
        until_offset_ = (status.moving ? kOffsetMoving : kOffsetAtRest) - 1;
        if (until_overrides_ == 0) until_overrides_ = 1;  // in the next report
        text += fmt::format("|WCO:{}", coordinates(status.work_offset, inches));
        if (hal) text += fmt::format("|H:{}|TLR:0", status.homed ? 1 : 0);
    }
    if (until_overrides_ > 0) {
        --until_overrides_;
    } else if (reports.overrides) {
        until_overrides_ = (status.moving ? kOverridesMoving : kOverridesAtRest) - 1;
        const GrblOverrides& overrides = status.overrides;
        text += fmt::format("|Ov:{},{},{}", overrides.feed, overrides.rapid, overrides.spindle);
        const std::string running = running_letters(status.modal);
        if (hal || !running.empty()) text += fmt::format("|A:{}", running);
    }
    return text + ">";
}

void GrblStatusReport::restart() {
    until_offset_ = 0;
    until_overrides_ = 0;
}

std::string probe_report(const GrblProbeRecord& record, bool inches) {
    return fmt::format("[PRB:{}:{}]", coordinates(record.position, inches), record.succeeded ? 1 : 0);
}

std::string banner(GrblDialect dialect) {
    switch (dialect) {
        case GrblDialect::grbl:
            return "Grbl 1.1h ['$' for help]";
        case GrblDialect::grblhal:
            return "GrblHAL 1.1f ['$' or '$HELP' for help]";
        case GrblDialect::fluidnc:
            return "Grbl 3.9 [FluidNC v3.9.1 (wifi) '$' for help]";
    }
    return "";
}

std::string parameters_report(const GrblFrame& frame, const std::optional<GrblProbeRecord>& record, bool inches) {
    std::string text;
    for (std::size_t i = 0; i < GrblFrame::kWorkSystems; ++i) {
        text += fmt::format("[G{}:{}]\r\n", 54 + i, coordinates(frame.work[i], inches));
    }
    const std::string zero = coordinates(Point::Zero(), inches);
    return fmt::format("{0}[G28:{1}]\r\n[G30:{1}]\r\n[G92:{2}]\r\n[TLO:{3}]\r\n{4}", text, zero, coordinates(frame.shift, inches),
                       number(0.0, inches ? 4 : 3), record ? probe_report(*record, inches) + "\r\n" : "");
}

std::string modal_report(const GrblModal& modal) {
    const std::string feed = number(modal.feed_mm_per_min / (modal.inches ? kInch : 1.0), modal.inches ? 1 : 0);
    const std::string coolant =
        fmt::format("{}{}{}", modal.mist ? " M7" : "", modal.flood ? " M8" : "", modal.mist || modal.flood ? "" : " M9");
    return fmt::format("[GC:{} G{} G17 {} {} G94 M{}{} T0 F{} S0]\r\n", g_word(modal.motion), 54 + modal.work_system,
                       modal.inches ? "G20" : "G21", modal.incremental ? "G91" : "G90", modal.spindle, coolant, feed);
}

std::string version_report(GrblDialect dialect) {
    if (dialect == GrblDialect::fluidnc) return "[VER:3.9 FluidNC v3.9.1:]\r\n[OPT:PHS]\r\n[MSG: Machine: virtual]\r\n";
    if (dialect == GrblDialect::grbl) return "[VER:1.1h.20190830:]\r\n[OPT:V,15,128]\r\n";
    return "[VER:1.1f.20230917:]\r\n[OPT:VNM,35,128,3,0]\r\n[AXS:3:XYZ]\r\n[FIRMWARE:grblHAL]\r\n";
}

}  // namespace palpate
