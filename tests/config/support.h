// What the tests of config/ share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "config/session_config.h"

namespace palpate::test {

// A folder of its own, gone with its owner.
class TemporaryFolder {
public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    TemporaryFolder(TemporaryFolder&&) = delete;
    TemporaryFolder& operator=(TemporaryFolder&&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }
    // Writes a file and returns where it is.
    [[nodiscard]] std::filesystem::path write(const std::string& name, const std::string& text) const;

private:
    std::filesystem::path path_;
};

// All files of config/examples.
[[nodiscard]] std::vector<std::filesystem::path> example_files();
[[nodiscard]] std::string contents(const std::filesystem::path& file);

// From PALPATE_TEST_SEED, or a fresh one; printed, so that a failure can be repeated.
[[nodiscard]] std::uint64_t logged_seed();

// Any config that respects the ranges of config/README.md.
[[nodiscard]] SessionConfig random_config(std::mt19937_64& random);

// All values equal, bit for bit.
[[nodiscard]] bool identical(const SessionConfig& a, const SessionConfig& b);

}  // namespace palpate::test
