// Reads the register map of a Modbus controller from its YAML file (config/profiles/standard.yaml says what is in one).
#pragma once

#include <filesystem>

#include "config/config_error.h"
#include "devices/modbus/modbus_profile.h"

namespace palpate {

// What comes back has passed check_profile. Throws ConfigError on unknown and missing keys, wrong types, and on what check_profile refuses.
[[nodiscard]] ModbusProfile read_modbus_profile(const std::filesystem::path& file);

}  // namespace palpate
