// What the tests of config/ share.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "config/session_config.h"

namespace palpate::test {

// Bytes that are not UTF-8: a byte of another encoding, alone, cut off, longer than need be, halves of pairs, beyond Unicode, and what
// begins with a byte that no character begins with.
inline constexpr std::array kNoCharacters = {"\xE9",
                                             "\x80",
                                             "\xC3",
                                             "\xE2\x82",
                                             "\xF0\x9F\x98",
                                             "\xC0\xAF",
                                             "\xC1\xBF",
                                             "\xE0\x80\xAF",
                                             "\xF0\x80\x80\xAF",
                                             "\xED\xA0\x80",
                                             "\xED\xBF\xBF",
                                             "\xF4\x90\x80\x80",
                                             "\xF5\x80\x80\x80",
                                             "\xF8\x88\x80\x80\x80",
                                             "\xFE\xFF"};
// The first and the last character of every length, and those around the halves of pairs.
inline constexpr std::array kCharacters = {"a",
                                           "~",
                                           "\xC2\xA0",
                                           "\xDF\xBF",
                                           "\xE0\xA0\x80",
                                           "\xED\x9F\xBF",
                                           "\xEE\x80\x80",
                                           "\xEF\xBF\xBF",
                                           "\xF0\x90\x80\x80",
                                           "\xF4\x8F\xBF\xBF"};

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
