// Which formats a result can be exported to, and what they are called.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

enum class ExportFormat : std::uint8_t { ply, stl, obj, off, three_mf, vtp, xyz, csv, dxf, bcnc, opencncpilot, candle, ugs };

// Of its name.
[[nodiscard]] std::optional<ExportFormat> parse_export_format(std::string_view name);
// Of a file's extension, where that says it.
[[nodiscard]] std::optional<ExportFormat> export_format_of(const std::filesystem::path& file);
// "ply, stl, ..."
[[nodiscard]] std::string export_format_names();
[[nodiscard]] bool is_height_map(ExportFormat format);

}  // namespace palpate
