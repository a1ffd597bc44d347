// Sets keys in the text of a configuration and leaves everything else as its author wrote it: order, comments, blanks.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/config_error.h"

namespace palpate {

struct KeyEdit {
    std::string key;    // full: "tool.calibration"; mappings on the way that are not there are made
    std::string value;  // YAML on one line: "[1, 2]", "{z: 0}"
    // The same as lines below the key, where the mapping around it is written in lines, too; empty: `value` behind the key.
    std::vector<std::string> lines{};
    std::string comment{};  // of a key in a line of its own, unless there is one already
};

// `name`: of the text, for messages. Throws ConfigError on a text that is no configuration's, and where a key stands in a form that this
// does not know: the message says what to write there by hand. What is returned has been read again: it differs in these keys alone.
[[nodiscard]] std::string edited_config(const std::string& text, const std::filesystem::path& name, const std::vector<KeyEdit>& edits);

// A text as a YAML value: in quotes where it needs them. Throws std::invalid_argument on what YAML cannot hold.
[[nodiscard]] std::string yaml_text(const std::string& text);

}  // namespace palpate
