#include "config/file_names.h"

#include <system_error>
#include <variant>

namespace palpate {
namespace {

namespace fs = std::filesystem;

using Rename = fs::path (*)(const fs::path& file, const fs::path& folder);

void rename_all(SessionConfig& config, const fs::path& folder, Rename rename) {
    if (auto* const mesh = config.object ? std::get_if<MeshSpec>(&*config.object) : nullptr) mesh->file = rename(mesh->file, folder);
    if (!config.calibration.file.empty()) config.calibration.file = rename(config.calibration.file, folder);
    if (!config.earlier.file.empty()) config.earlier.file = rename(config.earlier.file, folder);
    auto* const modbus = config.machine ? std::get_if<ModbusSpec>(&config.machine->connection) : nullptr;
    if (modbus != nullptr && !modbus->profile.empty()) modbus->profile = rename(modbus->profile, folder);
}

}  // namespace

fs::path absolute_name(const fs::path& file, const fs::path& folder) {
    const fs::path whole = fs::absolute(folder / file);
    std::error_code error;
    const fs::path parent = fs::weakly_canonical(whole.parent_path(), error);
    return error ? whole.lexically_normal() : parent / whole.filename();
}

fs::path relative_name(const fs::path& file, const fs::path& folder) {
    std::error_code error;
    const fs::path from = fs::weakly_canonical(fs::absolute(folder), error);
    if (error) return file;
    const fs::path name = absolute_name(file, folder).lexically_relative(from);
    return name.empty() ? file : name;
}

void make_names_absolute(SessionConfig& config, const fs::path& folder) { rename_all(config, folder, absolute_name); }
void make_names_relative(SessionConfig& config, const fs::path& folder) { rename_all(config, folder, relative_name); }

}  // namespace palpate
