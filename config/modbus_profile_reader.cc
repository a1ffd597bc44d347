#include "config/modbus_profile_reader.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "config/internal/section.h"
#include "config/internal/tree.h"

namespace palpate {
namespace {

using yaml::Need;
using yaml::Section;

constexpr std::array<std::string_view, 4> kTypes{"u16", "s16", "u32", "s32"};
constexpr std::array<std::string_view, 2> kWordOrders{"high_first", "low_first"};

// Too large ones are check_profile's to refuse.
int small_number(Section& section, const yaml::Key& key, int fallback = 0) {
    return static_cast<int>(
        std::min<std::uint64_t>(section.whole_number(key, static_cast<std::uint64_t>(fallback)), std::numeric_limits<int>::max()));
}

ModbusRegister read_register(Section& section) {
    ModbusRegister entry;
    entry.address = small_number(section, {"address", "of its first register, counted from 0", Need::required});
    const std::size_t type = section.word({"type", "width, and whether it can be negative"}, kTypes, 0);
    entry.bits = type < 2 ? 16 : 32;
    entry.is_signed = type % 2 == 1;
    entry.unit = section.number({"unit", "what one count means: mm, mm/s, mm/s²"}, yaml::kPositive, entry.unit);
    return entry;
}

ModbusProfile read_profile(Section& section) {
    ModbusProfile profile;
    profile.name = section.text({"name", "what the profile is called in messages", Need::required});
    section.mapping({"identity", "text that tells the controller from others", Need::required}, [&](Section& inner) {
        profile.identity.address = small_number(inner, {"address", "of its first register", Need::required});
        profile.identity.registers = small_number(inner, {"registers", "two characters each", Need::required});
        profile.expected_identity = inner.text({"expected", "what the text has to begin with", Need::required});
    });
    profile.word_order = static_cast<ModbusWordOrder>(section.word({"word_order", "of 32-bit values"}, kWordOrders, 0));
    profile.homed_bit = small_number(section, {"homed_bit", "of the status word: the position is true"}, profile.homed_bit);
    profile.probe_closed_bit =
        small_number(section, {"probe_closed_bit", "of the touch-probe status: the input as it is now"}, profile.probe_closed_bit);
    profile.heartbeat_limit = Seconds(
        section.number({"heartbeat_limit", "silence of the host after which the controller slows down and stops", Need::optional, "s"},
                       yaml::kPositive, profile.heartbeat_limit.count()));
    profile.echo_limit = Seconds(section.number({"echo_limit", "so late it may echo a heartbeat or a command", Need::optional, "s"},
                                                yaml::kPositive, profile.echo_limit.count()));
    profile.read_write =
        section.flag({"read_write", "whether it knows FC23: a heartbeat and the status in one request"}, profile.read_write);
    section.mapping({"registers", "where everything is", Need::required}, [&](Section& inner) {
        for (const ModbusField field : all_modbus_fields()) {
            inner.mapping({name_of(field), "see devices/README.md", Need::required},
                          [&](Section& entry) { profile[field] = read_register(entry); });
        }
    });
    section.finish();
    return profile;
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
        yaml::fail(root.where, "", spell(root) + " is not a mapping; allowed: a Modbus profile (config/profiles/standard.yaml)");
    }
    Section section(root, "");
    ModbusProfile profile = read_profile(section);
    try {
        check_profile(profile);
    } catch (const std::invalid_argument& flaw) {
        yaml::fail(whole, "", flaw.what());
    }
    return profile;
}

}  // namespace palpate
