#include "config/modbus_profile_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "config/internal/key_reader.h"
#include "config/internal/kinds.h"
#include "config/internal/tree.h"

namespace palpate {
namespace {

using yaml::KeyReader;
using yaml::Need;

constexpr std::array<std::string_view, 4> kTypes{"u16", "s16", "u32", "s32"};
constexpr std::array<std::string_view, 2> kWordOrders{"high_first", "low_first"};

// Too large ones are check_profile's to refuse.
void read_number(KeyReader& keys, const yaml::Key& key, int& field) {
    auto value = static_cast<std::uint64_t>(field);
    keys.value(key, value, yaml::Whole{});
    field = static_cast<int>(std::min<std::uint64_t>(value, std::numeric_limits<int>::max()));
}

void read_register(KeyReader& keys, ModbusRegister& entry) {
    read_number(keys, {"address", "of its first register, counted from 0", Need::required}, entry.address);
    std::size_t type = 0;
    keys.value({"type", "width, and whether it can be negative"}, type, yaml::Word{kTypes});
    entry.bits = type < 2 ? 16 : 32;
    entry.is_signed = type % 2 == 1;
    keys.value({"unit", "what one count means: mm, mm/s, mm/s²"}, entry.unit, yaml::Number{yaml::kPositive});
}

void read_identity(KeyReader& keys, ModbusProfile& profile) {
    read_number(keys, {"address", "of its first register", Need::required}, profile.identity.address);
    read_number(keys, {"registers", "two characters each", Need::required}, profile.identity.registers);
    keys.value({"expected", "what the text has to begin with", Need::required}, profile.expected_identity, yaml::Text{});
}

void read_profile(KeyReader& keys, ModbusProfile& profile) {
    const yaml::Number duration{yaml::kPositive};
    keys.value({"name", "what the profile is called in messages", Need::required}, profile.name, yaml::Text{});
    keys.mapping({"identity", "text that tells the controller from others", Need::required}, false,
                 [&](KeyReader& inner) { read_identity(inner, profile); });
    keys.value({"word_order", "of 32-bit values"}, profile.word_order, yaml::Word{kWordOrders});
    read_number(keys, {"homed_bit", "of the status word: the position is true"}, profile.homed_bit);
    read_number(keys, {"probe_closed_bit", "of the touch-probe status: the input as it is now"}, profile.probe_closed_bit);
    keys.value({"heartbeat_limit", "silence of the host after which the controller slows down and stops", Need::optional, yaml::kSeconds},
               profile.heartbeat_limit, duration);
    keys.value({"echo_limit", "so late it may echo a heartbeat or a command", Need::optional, yaml::kSeconds}, profile.echo_limit,
               duration);
    keys.value({"read_write", "whether it knows FC23: a heartbeat and the status in one request"}, profile.read_write, yaml::kFlag);
    keys.mapping({"registers", "where everything is", Need::required}, false, [&](KeyReader& inner) {
        for (const ModbusField field : all_modbus_fields()) {
            inner.mapping({name_of(field), "see devices/README.md", Need::required}, false,
                          [&](KeyReader& entry) { read_register(entry, profile[field]); });
        }
    });
    keys.finish();
}

}  // namespace

ModbusProfile read_modbus_profile(const std::filesystem::path& file) {
    const auto source = std::make_shared<const std::string>(file.string());
    const yaml::Location whole{source, 0};
    std::error_code ignored;  // what cannot be asked about cannot be opened either
    std::ifstream stream(file, std::ios::binary);
    if (!stream || std::filesystem::is_directory(file, ignored))
        yaml::fail(whole, "", "cannot be read; allowed: a YAML file that you may read");
    std::string text(yaml::kMaxBytes + 1, '\0');  // one byte more than is allowed is enough to be refused
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(stream.gcount()));
    const yaml::Value root = yaml::parse(text, {source, 1}, "");
    if (root.kind != yaml::Value::Kind::mapping) {
        yaml::fail(root.where, "",
                   fmt::format("{} is not a mapping; allowed: a Modbus profile (config/profiles/standard.yaml)", spell(root)));
    }
    KeyReader keys(root, "");
    ModbusProfile profile;
    read_profile(keys, profile);
    try {
        check_profile(profile);
    } catch (const std::invalid_argument& flaw) {
        yaml::fail(whole, "", flaw.what());
    }
    return profile;
}

}  // namespace palpate
