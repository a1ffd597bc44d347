#include "tools/formats/export_format.h"

#include <algorithm>
#include <array>

namespace palpate {
namespace {

struct Named {
    ExportFormat format;
    std::string_view name;
    std::string_view extension;  // empty: another format's
};

constexpr std::array<Named, 13> kFormats = {{{ExportFormat::ply, "ply", ".ply"},
                                             {ExportFormat::stl, "stl", ".stl"},
                                             {ExportFormat::obj, "obj", ".obj"},
                                             {ExportFormat::off, "off", ".off"},
                                             {ExportFormat::three_mf, "3mf", ".3mf"},
                                             {ExportFormat::vtp, "vtp", ".vtp"},
                                             {ExportFormat::xyz, "xyz", ".xyz"},
                                             {ExportFormat::csv, "csv", ".csv"},
                                             {ExportFormat::dxf, "dxf", ".dxf"},
                                             {ExportFormat::bcnc, "bcnc", ".probe"},
                                             {ExportFormat::opencncpilot, "opencncpilot", ".hmap"},
                                             {ExportFormat::candle, "candle", ".map"},
                                             {ExportFormat::ugs, "ugs", ""}}};

template <typename Is>
std::optional<ExportFormat> find(const Is& is) {
    const auto* const found = std::ranges::find_if(kFormats, is);
    return found == kFormats.end() ? std::nullopt : std::optional(found->format);
}

std::string in_small_letters(std::string text) {
    std::ranges::transform(text, text.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return text;
}

}  // namespace

std::optional<ExportFormat> parse_export_format(std::string_view name) {
    return find([&](const Named& named) { return named.name == name; });
}

std::optional<ExportFormat> export_format_of(const std::filesystem::path& file) {
    const std::string extension = in_small_letters(file.extension().string());
    return find([&](const Named& named) { return !named.extension.empty() && named.extension == extension; });
}

std::string export_format_names() {
    std::string names;
    for (const Named& named : kFormats) names += (names.empty() ? "" : ", ") + std::string(named.name);
    return names;
}

bool is_height_map(ExportFormat format) {
    return format == ExportFormat::bcnc || format == ExportFormat::opencncpilot || format == ExportFormat::candle ||
           format == ExportFormat::ugs;
}

}  // namespace palpate
