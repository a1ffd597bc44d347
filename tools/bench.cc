#include "tools/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "config/strategy_names.h"
#include "tools/session_files.h"
#include "tools/summary.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const BenchRow& row) {
    const Result& r = row.run.result;
    return {{"config", row.config},
            {"strategy", to_string(row.strategy)},
            {"epsilon", row.epsilon},
            {"samples", r.samples},
            {"samples_per_bound", static_cast<double>(r.samples) / r.lower_bound_samples},
            {"probes", r.cost.probes()},
            {"probes_per_sample", static_cast<double>(r.cost.probes()) / static_cast<double>(r.samples)},
            {"displacement", r.cost.displacement()},
            {"displacement_per_bound", r.cost.displacement() / r.lower_bound_displacement},
            {"euler_characteristic", r.topology.euler_characteristic},
            {"components", r.topology.components},
            {"nonmanifold_edges", r.topology.nonmanifold_edges},
            {"hausdorff", row.run.truth->hausdorff},
            {"status", to_string(r.certificate.status)},
            {"unsafe_moves", row.run.unsafe_moves},
            {"planner_seconds", row.run.planner_seconds},
            {"oracle_seconds", row.run.oracle_seconds}};
}

Json to_json(const std::vector<BenchRow>& rows) {
    Json json = Json::array();
    for (const BenchRow& row : rows) json.push_back(to_json(row));
    return json;
}

// For reading: few digits. The CSV and the JSON have all of them.
std::string short_text(const Json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (!value.is_number_float()) return value.dump();
    return fmt::format("{:.4g}", value.get<double>());
}

std::string csv_field(const Json& value) {
    if (!value.is_string()) return value.dump();
    std::string text = value.get<std::string>();
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    for (std::size_t k = 0; (k = text.find('"', k)) != std::string::npos; k += 2) text.insert(k, 1, '"');
    return fmt::format("\"{}\"", text);
}

using Cells = std::vector<std::vector<std::string>>;  // by row, the heads first

// Markdown, so that a table can be pasted into a document as it is. The first `words` columns hold words, the others numbers.
std::string markdown(const Cells& cells, std::size_t words) {
    std::string text;
    for (std::size_t line = 0; line < cells.size(); ++line) {
        std::string rule = "|";
        text += '|';
        for (std::size_t column = 0; column < cells[line].size(); ++column) {
            std::size_t width = 0;
            for (const auto& other : cells) width = std::max(width, other[column].size());
            const std::string& cell = cells[line][column];
            const std::string padding(width - cell.size(), ' ');
            text += column < words ? fmt::format(" {}{} |", cell, padding) : fmt::format(" {}{} |", padding, cell);
            rule += column < words ? std::string(width + 2, '-') + '|' : std::string(width + 1, '-') + ":|";
        }
        text += '\n';
        if (line == 0) text += rule + '\n';
    }
    return text;
}

}  // namespace

std::string bench_json(const std::vector<BenchRow>& rows) { return to_json(rows).dump(2) + '\n'; }

std::string bench_csv(const std::vector<BenchRow>& rows) {
    std::string text;
    for (const Json& row : to_json(rows)) {
        std::string names;
        std::string values;
        for (const auto& [name, value] : row.items()) {
            names += (names.empty() ? "" : ",") + name;
            values += (values.empty() ? "" : ",") + csv_field(value);
        }
        if (text.empty()) text = names + '\n';
        text += values + '\n';
    }
    return text;
}

std::string bench_table(const std::vector<BenchRow>& rows, int columns) {
    Cells cells;
    for (const Json& row : to_json(rows)) {
        std::vector<std::string> names;
        std::vector<std::string> values;
        for (const auto& [name, value] : row.items()) {
            names.push_back(name);
            values.push_back(short_text(value));
        }
        if (cells.empty()) cells.push_back(names);
        cells.push_back(values);
    }
    std::string wide = markdown(cells, 2);
    if (columns == 0 || wide.find('\n') <= static_cast<std::size_t>(columns)) return wide;
    // Runs beside each other, as many as fit, one quantity below the other.
    std::string text;
    for (std::size_t first = 1; first < cells.size();) {
        std::string block;
        std::size_t last = first;
        do {
            Cells turned(cells.front().size());
            for (std::size_t quantity = 0; quantity < turned.size(); ++quantity) {
                turned[quantity].push_back(cells.front()[quantity]);
                for (std::size_t run = first; run <= last; ++run) turned[quantity].push_back(cells[run][quantity]);
            }
            const std::string longer = markdown(turned, 1);
            if (!block.empty() && longer.find('\n') > static_cast<std::size_t>(columns)) break;
            block = longer;
            ++last;
        } while (last < cells.size());
        text += (text.empty() ? "" : "\n") + block;
        first = last;
    }
    return text;
}

}  // namespace palpate
