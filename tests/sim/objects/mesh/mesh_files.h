// Mesh files that a test writes, and meshes to write.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include "planner/geometry.h"
#include "sim/objects/errors.h"
#include "sim/objects/mesh/mesh_object.h"
#include "tests/off_text.h"

namespace palpate {

class MeshFiles : public testing::Test {
protected:
    MeshFiles() {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::path(testing::TempDir()) / (std::string("palpate_") + info->test_suite_name() + "_" + info->name());
        std::filesystem::create_directories(folder_);
    }
    ~MeshFiles() override { std::filesystem::remove_all(folder_); }

    [[nodiscard]] std::filesystem::path write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return folder_ / name;
    }
    [[nodiscard]] static std::filesystem::path test_case(const std::string& name) {
        return std::filesystem::path(PALPATE_TEST_DATA) / "cases" / name;
    }
    [[nodiscard]] std::filesystem::path write_off(const std::string& name, const TriangleMesh& mesh) const {
        return write(name, off_text(mesh));
    }

    static std::string message_of(const MeshSpec& spec) {
        try {
            const MeshObject object(spec);
        } catch (const ObjectError& error) {
            return error.what();
        }
        return "";
    }

    std::filesystem::path folder_;
};

inline TriangleMesh turned(TriangleMesh mesh) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

inline TriangleMesh moved(TriangleMesh mesh, const Vector& by) {
    for (Point& p : mesh.points) p += by;
    return mesh;
}

inline TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
    const auto shift = static_cast<std::uint32_t>(a.points.size());
    a.points.insert(a.points.end(), b.points.begin(), b.points.end());
    for (const auto& [i, j, k] : b.triangles) a.triangles.push_back({i + shift, j + shift, k + shift});
    return a;
}

// A tetrahedron with a right corner at the origin and legs of 1 mm.
inline TriangleMesh tetrahedron() {
    return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{{0, 2, 1}}, {{0, 1, 3}}, {{1, 2, 3}}, {{2, 0, 3}}}};
}

inline void expect_contains(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << "in: " << text << "\nno: " << part;
}

}  // namespace palpate
