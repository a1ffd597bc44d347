#include "config/writer.h"

#include <utility>

#include "config/file_names.h"
#include "config/internal/key_writer.h"
#include "config/internal/session_keys.h"

namespace palpate {

namespace {

// `fields`: what is declared for the reader, too, takes them to be its own.
std::string text_of(SessionConfig fields) {
    yaml::KeyWriter writer;
    describe(writer, fields);
    std::string text;
    for (const std::string& line : writer.lines()) {
        text += line + "\n";
    }
    return text;
}

}  // namespace

std::string write_config(const SessionConfig& config) {
    SessionConfig whole = config;
    make_names_absolute(whole, std::filesystem::current_path());
    return text_of(std::move(whole));
}

std::string write_config(const SessionConfig& config, const std::filesystem::path& folder) {
    SessionConfig moved = config;
    make_names_relative(moved, folder);
    return text_of(std::move(moved));
}

std::string shape_name(const ShapeSpec& shape) {
    yaml::KeyWriter writer;
    ShapeSpec fields = shape;
    describe(writer, fields);
    const std::string& first = writer.lines().front();  // its kind is declared first
    return first.substr(0, first.find(':'));
}

}  // namespace palpate
