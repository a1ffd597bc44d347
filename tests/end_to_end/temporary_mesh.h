// A mesh as users give one: by its file.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "planner/geometry.h"
#include "tests/off_text.h"

namespace palpate {

class TemporaryMesh {
public:
    TemporaryMesh(const TriangleMesh& mesh, const std::string& name)
        : path_(std::filesystem::temp_directory_path() / (name + std::to_string(::getpid()) + ".off")) {
        std::ofstream(path_) << off_text(mesh);
    }
    TemporaryMesh(const TemporaryMesh&) = delete;
    TemporaryMesh& operator=(const TemporaryMesh&) = delete;
    ~TemporaryMesh() { std::filesystem::remove(path_); }
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

}  // namespace palpate
