// A configuration file: what is read can be written, and reads back the same.
#include <string>

#include "config/reader.h"
#include "config/writer.h"
#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace palpate;
    SessionConfig config;
    try {
        config = read_config_text(std::string(reinterpret_cast<const char*>(data), size), "/fuzz/config.yaml");
    } catch (const ConfigError&) {
        return 0;
    }
    std::string text;
    try {
        text = write_config(config);
    } catch (const std::invalid_argument&) {
        return 0;  // a file name that is not UTF-8
    }
    require(write_config(read_config_text(text, "/fuzz/config.yaml")) == text, "what is written reads back the same");
    return 0;
}
