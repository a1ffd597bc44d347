#include "config/writer.h"

#include "config/internal/key_writer.h"
#include "config/internal/session_keys.h"

namespace palpate {

std::string write_config(const SessionConfig& config) {
    yaml::KeyWriter writer;
    SessionConfig fields = config;  // what is declared for the reader, too, takes them to be its own
    describe(writer, fields);
    std::string text;
    for (const std::string& line : writer.lines()) {
        text += line + "\n";
    }
    return text;
}

}  // namespace palpate
