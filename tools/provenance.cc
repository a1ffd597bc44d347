#include "tools/provenance.h"

#include <fmt/format.h>
#include <nettle/sha2.h>

#include <array>
#include <fstream>
#include <iterator>
#include <utility>
#include <variant>

#include "config/file_names.h"
#include "config/writer.h"
#include "devices/version.h"
#include "tools/summary.h"

namespace palpate {

Provenance provenance_of(const SessionConfig& config, const std::filesystem::path& folder, std::string config_digest,
                         std::string object_sha256) {
    Provenance provenance{std::move(config_digest)};
    if (!config.object) return provenance;
    if (const auto* const mesh = std::get_if<MeshSpec>(&*config.object)) {
        provenance.mesh = relative_name(mesh->file, folder).string();
        provenance.object_sha256 = std::move(object_sha256);
    } else {
        provenance.shape = shape_name(std::get<ShapeSpec>(*config.object));
    }
    return provenance;
}

std::string object_sha256(const SessionConfig& config) {
    const auto* const mesh = config.object ? std::get_if<MeshSpec>(&*config.object) : nullptr;
    return mesh != nullptr ? file_sha256(mesh->file) : "";
}

std::string file_sha256(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) return "";
    sha256_ctx context;
    sha256_init(&context);
    std::array<char, 1 << 16> buffer{};
    do {
        in.read(buffer.data(), buffer.size());
        sha256_update(&context, static_cast<std::size_t>(in.gcount()), reinterpret_cast<const std::uint8_t*>(buffer.data()));
    } while (in);
    if (in.bad()) return "";
    std::array<std::uint8_t, SHA256_DIGEST_SIZE> sum{};
    sha256_digest(&context, sum.size(), sum.data());
    std::string text;
    for (const std::uint8_t byte : sum) fmt::format_to(std::back_inserter(text), "{:02x}", byte);
    return text;
}

std::vector<std::string> mesh_comments(const Provenance& provenance, const Certificate& certificate) {
    std::vector<std::string> comments = {fmt::format("made by Palpate {}; millimetres", program_version()),
                                         fmt::format("configuration: CRC-32 {}", provenance.config_digest)};
    if (!provenance.object_sha256.empty()) comments.push_back(fmt::format("object: SHA-256 {}", provenance.object_sha256));
    using Status = Certificate::Status;
    if (certificate.status == Status::incomplete || certificate.status == Status::refuted) {
        comments.push_back(fmt::format("{}: {}", to_string(certificate.status), certificate.statement));
    }
    return comments;
}

}  // namespace palpate
