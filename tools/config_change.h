// A configuration that a command changes: what was there is kept beside it.
#pragma once

#include <filesystem>
#include <string>

namespace palpate {

// Puts `text` in place of the file, whose old text is kept in FILE.bak, or FILE.bak2 and so on where there is one already. Returns the name
// of that. Throws OutputError, with the file as it was.
std::filesystem::path change_config(const std::filesystem::path& file, const std::string& text);

// Throws OutputError unless `file` can be written. What is there stays.
void require_writable(const std::filesystem::path& file);

}  // namespace palpate
