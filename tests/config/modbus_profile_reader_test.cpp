#include "config/modbus_profile_reader.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/config/support.h"

namespace palpate::modbus_profile_reader_test {
namespace {

std::filesystem::path standard_file() { return std::filesystem::path(PALPATE_CONFIG_DIR) / "profiles" / "standard.yaml"; }

// standard.yaml with one text put in the place of another, which has to be there.
std::string changed(const std::string& from, const std::string& to) {
    std::string text = test::contents(standard_file());
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

ModbusProfile read_text(const std::string& text) {
    const test::TemporaryFolder folder;
    return read_modbus_profile(folder.write("profile.yaml", text));
}

void expect_refused(const std::string& text, const std::string& naming) {
    try {
        (void)read_text(text);
        ADD_FAILURE() << "accepted, although wrong: " << naming;
    } catch (const ConfigError& error) {
        EXPECT_NE(std::string(error.what()).find(naming), std::string::npos) << error.what();
    }
}

TEST(ModbusProfileReader, TheFileOfTheStandardIsTheStandard) {
    const ModbusProfile read = read_modbus_profile(standard_file());
    const ModbusProfile standard = ModbusProfile::standard();
    EXPECT_EQ(read.name, standard.name);
    EXPECT_EQ(read.word_order, standard.word_order);
    EXPECT_EQ(read.identity.address, standard.identity.address);
    EXPECT_EQ(read.identity.registers, standard.identity.registers);
    EXPECT_EQ(read.expected_identity, standard.expected_identity);
    EXPECT_EQ(read.homed_bit, standard.homed_bit);
    EXPECT_EQ(read.probe_closed_bit, standard.probe_closed_bit);
    EXPECT_EQ(read.heartbeat_limit, standard.heartbeat_limit);
    EXPECT_EQ(read.echo_limit, standard.echo_limit);
    EXPECT_EQ(read.read_write, standard.read_write);
    for (const ModbusField field : all_modbus_fields()) EXPECT_EQ(read[field], standard[field]) << name_of(field);
}

TEST(ModbusProfileReader, AnotherControllerNeedsNoCode) {
    std::string text = changed("word_order: high_first", "word_order: low_first");
    const std::string from = "status_word: {address: 512}";
    text.replace(text.find(from), from.size(), "status_word: {address: 600}");
    const std::string sped = "velocity: {address: 263, type: u32, unit: 0.001}";
    text.replace(text.find(sped), sped.size(), "velocity: {address: 263, type: u32, unit: 0.5}");
    const std::string both = "read_write: true";
    text.replace(text.find(both), both.size(), "");
    const ModbusProfile read = read_text(text);
    EXPECT_FALSE(read.read_write) << "nobody is asked for a function that he may not know";
    EXPECT_EQ(read.word_order, ModbusWordOrder::low_first);
    EXPECT_EQ(read[ModbusField::status_word].address, 600);
    EXPECT_EQ(read[ModbusField::velocity].unit, 0.5);
}

TEST(ModbusProfileReader, WhatIsWrongIsNamed) {
    expect_refused(changed("stop_on_touch", "stop_at_touch"), "did you mean \"stop_on_touch\"");
    expect_refused(changed("  heartbeat_echo: {address: 529}", ""), "registers.heartbeat_echo: is required");
    expect_refused(changed("type: s32", "type: float"), "registers.target_x.type");
    expect_refused(changed("{address: 512}", "{adress: 512}"), "address");
    expect_refused(changed("{address: 512}", "{address: 515}"), "actual_x");
    expect_refused(changed("{address: 288}", "{address: 99999999999}"), "heartbeat");
    expect_refused(changed("homed_bit: 14", "homed_bit: 16"), "homed_bit");
    expect_refused(changed("echo_limit: 0.5", "echo_limit: 0"), "echo_limit");
    expect_refused("[1, 2]", "standard.yaml");
    expect_refused("", "");
}

TEST(ModbusProfileReader, AFileThatIsNotThereIsNamed) {
    try {
        (void)read_modbus_profile("/nonexistent/profile.yaml");
        ADD_FAILURE() << "nothing was thrown";
    } catch (const ConfigError& error) {
        EXPECT_NE(std::string(error.what()).find("/nonexistent/profile.yaml"), std::string::npos) << error.what();
    }
    EXPECT_THROW((void)read_modbus_profile("/"), ConfigError);
}

}  // namespace
}  // namespace palpate::modbus_profile_reader_test
