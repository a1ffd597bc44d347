// Runs a fuzz target without libFuzzer: every file of a corpus, then random changes of them for a while. Usage: TARGET CORPUS SECONDS
// [SEED]. The input that is under way is kept in crash-TARGET, so that what ends the process can be looked at and put into the corpus.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/fuzz/fuzz_target.h"
#include "tests/random.h"

namespace {

namespace fs = std::filesystem;
using palpate::Random;

constexpr std::size_t kLongest = 20'000;

std::vector<std::string> read_corpus(const fs::path& folder) {
    std::vector<std::string> inputs;
    for (const auto& entry : fs::directory_iterator(folder)) {
        std::ifstream in(entry.path(), std::ios::binary);
        inputs.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
    std::sort(inputs.begin(), inputs.end());
    return inputs;
}

void change(std::string& input, const std::vector<std::string>& corpus, Random& random) {
    const std::size_t at = random.below(input.size() + 1);
    const std::size_t length = std::min(random.below(16), input.size() - at);
    switch (random.below(7)) {
        case 0:
            input.insert(at, 1, static_cast<char>(random.below(256)));
            break;
        case 1:
            input.erase(at, length);
            break;
        case 2:
            if (at < input.size()) input[at] = static_cast<char>(input[at] ^ (1 << random.below(8)));
            break;
        case 3:
            input.insert(at, input.substr(random.below(input.size() + 1), 1 + random.below(32)));
            break;
        case 4: {
            const std::string& other = random.one_of(corpus);
            input.insert(at, other.substr(random.below(other.size() + 1), 1 + random.below(64)));
            break;
        }
        case 5:
            if (at < input.size()) input[at] = "0123456789-.,:{}[]\n\r\t\"e"[random.below(23)];
            break;
        default:
            input.resize(at);
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::cerr << "usage: " << argv[0] << " CORPUS SECONDS [SEED]\n";
        return 2;
    }
    const std::vector<std::string> corpus = read_corpus(argv[1]);
    if (corpus.empty()) {
        std::cerr << argv[1] << ": an empty corpus\n";
        return 2;
    }
    const std::uint64_t seed = argc > 3 ? std::stoull(argv[3]) : 1;
    const std::string keep = "crash-" + fs::path(argv[0]).filename().string();
    const auto run = [&](const std::string& input) {
        std::ofstream(keep, std::ios::binary) << input;
        LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
    };
    for (const std::string& input : corpus) run(input);
    Random random(seed);
    std::uint64_t runs = 0;
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(std::stod(argv[2]));
    while (std::chrono::steady_clock::now() < end) {
        std::string input = random.one_of(corpus);
        for (std::size_t changes = 1 + random.below(6); changes > 0; --changes) change(input, corpus, random);
        if (input.size() > kLongest) input.resize(kLongest);
        run(input);
        ++runs;
    }
    fs::remove(keep);
    std::cout << corpus.size() << " inputs of the corpus and " << runs << " changed ones, seed " << seed << '\n';
    return runs > 0 ? 0 : 1;
}
