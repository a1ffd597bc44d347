// Damaged mesh files: whatever is in the file, it is read or refused with ObjectError, in bounded time.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/sim/objects/mesh/mesh_files.h"

namespace palpate::mesh_fuzz_test {
namespace {

using namespace std::string_literals;

// What tends to hurt readers of meshes.
const std::array kTokens{"\n"s,
                         " "s,
                         "\0"s,
                         "-1 "s,
                         "99999999999999999999 "s,
                         "1e308 "s,
                         "-1e-308 "s,
                         "nan "s,
                         "0 "s,
                         "7 "s,
                         "\\\n"s,
                         "# "s,
                         "f 1 2 3\n"s,
                         "facet "s,
                         "endsolid\n"s,
                         "property list uchar int x\n"s,
                         "element face 4000000000\n"s,
                         "end_header\n"s,
                         "\xFF\xFF\xFF\xFF"s,
                         "\x7F\xC0\x00\x00"s};

std::size_t below(std::mt19937_64& random, std::size_t bound) { return bound == 0 ? 0 : static_cast<std::size_t>(random() % bound); }

void mutate(std::string& bytes, std::mt19937_64& random) {
    const std::size_t at = below(random, bytes.size() + 1);
    const std::size_t length = std::min(below(random, 40), bytes.size() - at);
    switch (random() % 6) {
        case 0:
            bytes.resize(at);
            break;
        case 1:
            bytes.erase(at, length);
            break;
        case 2:
            bytes.insert(below(random, bytes.size() + 1), bytes.substr(at, length));
            break;
        case 3:
            bytes.insert(at, kTokens[below(random, kTokens.size())]);
            break;
        default:
            if (at < bytes.size()) bytes[at] = static_cast<char>(static_cast<unsigned char>(bytes[at]) ^ (1U << (random() % 8)));
    }
}

// Nothing may be written to the terminal; what a failing test says is kept until then.
class Silence {
public:
    Silence() {
        testing::internal::CaptureStdout();
        testing::internal::CaptureStderr();
    }
    ~Silence() {
        EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    }
    Silence(const Silence&) = delete;
    Silence& operator=(const Silence&) = delete;
};

std::string contents(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

// "read", or why not.
std::string outcome(const std::filesystem::path& file) {
    try {
        const MeshObject object({file});
        return "read";
    } catch (const ObjectError& error) {
        return error.what();
    } catch (const std::exception& error) {
        return std::string("not an ObjectError: ") + error.what();
    }
}

TEST_F(MeshFiles, DamagedFilesAreReadOrRefused) {
    constexpr int kRounds = 4000;
    constexpr std::uint64_t kSeed = 11;
    constexpr std::chrono::seconds kLimit{2};  // for one file
    std::vector<std::filesystem::path> corpus;
    std::ranges::copy(std::filesystem::directory_iterator(test_case("")), std::back_inserter(corpus));
    std::ranges::sort(corpus);
    std::mt19937_64 random(kSeed);
    const Silence silence;
    int read = 0;
    for (int round = 0; round < kRounds; ++round) {
        const std::filesystem::path& original = corpus[below(random, corpus.size())];
        std::string bytes = contents(original);
        for (std::size_t count = 1 + below(random, 3); count > 0; --count) mutate(bytes, random);
        const auto file = write("damaged" + original.extension().string(), bytes);
        const auto start = std::chrono::steady_clock::now();
        const std::string result = outcome(file);
        ASSERT_LT(std::chrono::steady_clock::now() - start, kLimit) << "round " << round << ":\n" << bytes;
        if (result == "read") ++read;
        ASSERT_TRUE(result == "read" || result.starts_with(file.string() + ": ")) << result << "\nround " << round << ":\n" << bytes;
    }
    EXPECT_GT(read, kRounds / 50);
    EXPECT_LT(read, kRounds);
}

}  // namespace
}  // namespace palpate::mesh_fuzz_test
