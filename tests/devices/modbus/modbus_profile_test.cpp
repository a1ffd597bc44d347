#include "devices/modbus/modbus_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>

#include "devices/errors.h"
#include "tests/random.h"

namespace palpate::modbus_profile_test {
namespace {

TEST(ModbusProfile, TheStandardIsSound) {
    const ModbusProfile profile = ModbusProfile::standard();
    EXPECT_NO_THROW(check_profile(profile));
    EXPECT_EQ(span_of(profile, ModbusBlock::command).address, 256);
    EXPECT_EQ(span_of(profile, ModbusBlock::command).registers, 14);
    EXPECT_EQ(span_of(profile, ModbusBlock::status).registers, 18);
    EXPECT_EQ(span_of(profile, ModbusBlock::limits).registers, 12);
    EXPECT_EQ(name_of(ModbusField::control_word), "control_word");
    EXPECT_EQ(name_of(ModbusField::sequence_echo), "sequence_echo");
    EXPECT_EQ(name_of(ModbusField::max_z), "max_z");
    EXPECT_EQ(axis_of(ModbusField::latched_x, 2), ModbusField::latched_z);
}

// devices/FACTS.md, "Modbus", conventions: 32-bit values high word first.
TEST(ModbusProfile, ThirtyTwoBitValuesHaveTheHighWordFirst) {
    ModbusProfile profile = ModbusProfile::standard();
    std::array<std::uint16_t, 2> words{};
    put_value(words, profile[ModbusField::target_x].address, profile, ModbusField::target_x, 70.0);  // 70000 = 0x00011170
    EXPECT_EQ(words, (std::array<std::uint16_t, 2>{0x0001, 0x1170}));
    profile.word_order = ModbusWordOrder::low_first;
    put_value(words, profile[ModbusField::target_x].address, profile, ModbusField::target_x, 70.0);
    EXPECT_EQ(words, (std::array<std::uint16_t, 2>{0x1170, 0x0001}));
    profile.word_order = ModbusWordOrder::high_first;
    put_value(words, profile[ModbusField::target_x].address, profile, ModbusField::target_x, -0.001);
    EXPECT_EQ(words, (std::array<std::uint16_t, 2>{0xFFFF, 0xFFFF}));
}

TEST(ModbusProfile, ValuesComeBackToTheNearestCount) {
    constexpr std::uint64_t kSeed = 11;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (int i = 0; i < 2000; ++i) {
        ModbusProfile profile = ModbusProfile::standard();
        profile.word_order = random.chance(0.5) ? ModbusWordOrder::high_first : ModbusWordOrder::low_first;
        ModbusRegister& entry = profile[ModbusField::actual_y];
        entry = {random.chance(0.5) ? 0 : 7, random.chance(0.5) ? 16 : 32, random.chance(0.5), random.chance(0.5) ? 0.001 : 0.25};
        const double span = std::exp2(entry.bits) * entry.unit;
        const double value = entry.is_signed ? random.uniform(-0.499 * span, 0.499 * span) : random.uniform(0, 0.999 * span);
        std::array<std::uint16_t, 9> words{};
        put_value(words, 0, profile, ModbusField::actual_y, value);
        EXPECT_NEAR(get_value(words, 0, profile, ModbusField::actual_y), value, 0.5001 * entry.unit);
    }
}

TEST(ModbusProfile, AValueThatDoesNotFitIsRefused) {
    const ModbusProfile profile = ModbusProfile::standard();
    std::array<std::uint16_t, 2> words{};
    const int target = profile[ModbusField::target_x].address;
    EXPECT_NO_THROW(put_value(words, target, profile, ModbusField::target_x, 2147483.647));
    EXPECT_THROW(put_value(words, target, profile, ModbusField::target_x, 2147483.648), OutOfLimits);
    EXPECT_NO_THROW(put_value(words, target, profile, ModbusField::target_x, -2147483.648));
    EXPECT_THROW(put_value(words, target, profile, ModbusField::target_x, -2147483.649), OutOfLimits);
    EXPECT_THROW(put_value(words, target, profile, ModbusField::target_x, std::nan("")), OutOfLimits);
    EXPECT_THROW(put_value(words, profile[ModbusField::velocity].address, profile, ModbusField::velocity, -1), OutOfLimits);
}

TEST(ModbusProfile, TextIsTwoCharactersARegister) {
    const std::vector<std::uint16_t> words = registers_of_text("abc", 4);
    EXPECT_EQ(words, (std::vector<std::uint16_t>{0x6162, 0x6300, 0, 0}));
    EXPECT_EQ(text_of_registers(words), "abc");
    EXPECT_EQ(text_of_registers(registers_of_text("abc  ", 4)), "abc");
    EXPECT_EQ(text_of_registers(registers_of_text("abcdefgh", 2)), "abcd");
    EXPECT_EQ(text_of_registers({}), "");
}

struct Flaw {
    std::string entry;  // has to be named
    std::function<void(ModbusProfile&)> make;
};

TEST(ModbusProfile, EveryFlawIsNamed) {
    using F = ModbusField;
    const std::vector<Flaw> flaws = {
        {"target_y", [](ModbusProfile& p) { p[F::target_y].bits = 24; }},
        {"target_y", [](ModbusProfile& p) { p[F::target_y].is_signed = false; }},
        {"velocity", [](ModbusProfile& p) { p[F::velocity].unit = 0; }},
        {"velocity", [](ModbusProfile& p) { p[F::velocity].unit = std::nan(""); }},
        {"status_word", [](ModbusProfile& p) { p[F::status_word].bits = 32; }},
        {"edge_counter", [](ModbusProfile& p) { p[F::edge_counter].unit = 2; }},
        {"heartbeat", [](ModbusProfile& p) { p[F::heartbeat].address = 65536; }},
        {"heartbeat", [](ModbusProfile& p) { p[F::heartbeat].address = -1; }},
        {"max_z", [](ModbusProfile& p) { p[F::max_z].address = 65535; }},
        {"latched_x", [](ModbusProfile& p) { p[F::latched_x].address = p[F::edge_counter].address; }},
        {"identity", [](ModbusProfile& p) { p.identity.address = 500; }},  // it reaches into the status block
        {"identity", [](ModbusProfile& p) { p.identity.registers = 0; }},
        {"identity", [](ModbusProfile& p) { p.identity.address = 65530; }},
        {"command block", [](ModbusProfile& p) { p[F::sequence].address += 1; }},
        {"status block", [](ModbusProfile& p) { p[F::status_word].address = 300; }},
        {"limits block", [](ModbusProfile& p) { p[F::max_z].address = 2000; }},
        {"homed_bit", [](ModbusProfile& p) { p.homed_bit = 16; }},
        {"probe_closed_bit", [](ModbusProfile& p) { p.probe_closed_bit = -1; }},
        {"heartbeat_limit", [](ModbusProfile& p) { p.heartbeat_limit = Seconds(0); }},
    };
    for (const Flaw& flaw : flaws) {
        ModbusProfile profile = ModbusProfile::standard();
        flaw.make(profile);
        try {
            check_profile(profile);
            ADD_FAILURE() << flaw.entry << " was accepted";
        } catch (const std::invalid_argument& error) {
            EXPECT_NE(std::string(error.what()).find(flaw.entry), std::string::npos) << error.what();
        }
    }
}

}  // namespace
}  // namespace palpate::modbus_profile_test
