#include "tools/config_change.h"

#include <fmt/format.h>

#include "tools/session_files.h"

namespace palpate {

namespace fs = std::filesystem;

fs::path change_config(const fs::path& file, const std::string& text) {
    const fs::path itself = fs::weakly_canonical(file);  // a link stays one
    fs::path kept = file.string() + ".bak";
    for (int k = 2; fs::exists(kept); ++k) kept = fmt::format("{}.bak{}", file.string(), k);
    write_file(kept, read_file(itself));
    write_file(itself, text);
    return kept;
}

void require_writable(const fs::path& file) {
    if (fs::exists(file)) return write_file(file, read_file(file));
    write_file(file, "");
    fs::remove(file);
}

}  // namespace palpate
