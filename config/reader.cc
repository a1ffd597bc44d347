#include "config/reader.h"

#include <fmt/format.h>

#include <fstream>
#include <memory>
#include <system_error>

#include "config/file_names.h"
#include "config/internal/key_reader.h"
#include "config/internal/session_keys.h"
#include "config/internal/tree.h"

namespace palpate {

namespace {

// The text of a file, or one byte more than is allowed of it.
std::string slurp(const std::filesystem::path& file, const yaml::Location& whole) {
    std::error_code ignored;  // what cannot be asked about cannot be opened either
    if (std::filesystem::is_directory(file, ignored)) {
        yaml::fail(whole, "", "is a folder; allowed: a YAML file");
    }
    std::ifstream stream(file, std::ios::binary);
    if (!stream) {
        yaml::fail(whole, "",
                   std::filesystem::exists(file, ignored) ? "cannot be read; allowed: a file that you may read"
                                                          : "does not exist; allowed: a YAML file");
    }
    std::string text(yaml::kMaxBytes + 1, '\0');
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(stream.gcount()));
    return text;
}

}  // namespace

SessionConfig read_config(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
    return read_config_text(slurp(file, {std::make_shared<const std::string>(file.string()), 0}), file, overrides);
}

SessionConfig read_config_text(const std::string& text, const std::filesystem::path& name, const std::vector<std::string>& overrides) {
    const auto source = std::make_shared<const std::string>(name.string());
    yaml::Value root = yaml::parse(text, {source, 1}, "");
    if (root.kind != yaml::Value::Kind::mapping) {
        yaml::fail(root.where, "", fmt::format("{} is not a mapping; allowed: a mapping with at least the key probing", spell(root)));
    }
    for (const std::string& assignment : overrides) {
        yaml::apply_override(root, assignment);
    }
    yaml::KeyReader reader(root, "");
    SessionConfig config;
    describe(reader, config);
    reader.finish();
    // A part on a fixture has a crease where it stands, and one where the walls of an area cut it: no bound on the reach holds there.
    Strategy::Infer& infer = config.probing.strategy.infer;
    if (infer == Strategy::Infer::automatic && (!config.fixtures.solids.empty() || config.area)) infer = Strategy::Infer::adaptive;
    make_names_absolute(config, std::filesystem::absolute(name).parent_path());
    return config;
}

}  // namespace palpate
