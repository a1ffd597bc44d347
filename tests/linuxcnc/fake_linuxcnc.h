// LinuxCNC's bridge beside a LinuxCNC that is made up (fake/linuxcnc.py).
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>

#include "devices/external/external_device.h"
#include "devices/posix/child_stream.h"
#include "devices/posix/tcp_stream.h"

namespace palpate::test {

class FakeLinuxCnc {
public:
    // `wrong`: what the module reads (fake/linuxcnc.py).
    explicit FakeLinuxCnc(const nlohmann::json& wrong = nlohmann::json::object()) {
        std::string name = (std::filesystem::temp_directory_path() / "palpate-linuxcnc-XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder for LinuxCNC's log");
        folder_ = name;
        std::ofstream(log_path()).flush();
        // The bridge ends with its LinuxCNC, not with its input.
        const std::string script = fmt::format(
            "PYTHONDONTWRITEBYTECODE=1 PYTHONPATH={0}/tests/linuxcnc/fake PALPATE_FAKE_LOG={1} PALPATE_FAKE_LINUXCNC='{2}' "
            "/usr/bin/python3 "
            "{0}/tools/linuxcnc_bridge --listen 127.0.0.1:0 & cat >/dev/null; kill $!; wait $!",
            PALPATE_SOURCE_DIR, log_path().string(), wrong.dump());
        program_ = std::make_unique<ChildStream>(std::vector<std::string>{"sh", "-c", script});
        std::string said;
        while (said.find('\n') == std::string::npos) said += program_->read(std::chrono::seconds(1));
        address_ = said.substr(said.find("127."));
        address_.erase(address_.find('\n'));
    }
    ~FakeLinuxCnc() {
        program_.reset();
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }
    FakeLinuxCnc(const FakeLinuxCnc&) = delete;
    FakeLinuxCnc& operator=(const FakeLinuxCnc&) = delete;
    FakeLinuxCnc(FakeLinuxCnc&&) = delete;
    FakeLinuxCnc& operator=(FakeLinuxCnc&&) = delete;

    [[nodiscard]] std::unique_ptr<TcpStream> connect() const { return std::make_unique<TcpStream>(*parse_host_port(address_)); }
    [[nodiscard]] int port() const { return parse_host_port(address_)->port; }
    // How often LinuxCNC was told something that begins so.
    [[nodiscard]] std::size_t told(const std::string& what) const {
        std::ifstream file(log_path());
        std::size_t count = 0;
        for (std::string line; std::getline(file, line);) count += line.starts_with(what) ? 1 : 0;
        return count;
    }
    [[nodiscard]] std::size_t moves() const { return told("mdi G38"); }
    // Somebody at the machine, who has done it when this returns.
    void hand(const std::string& word) const {
        const std::filesystem::path path = log_path().string() + ".hand";
        std::ofstream(path.string() + "~") << word;
        std::filesystem::rename(path.string() + "~", path);
        while (std::filesystem::exists(path)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    void place(const Point& p) const { hand(fmt::format("place {} {} {}", p.x(), p.y(), p.z())); }
    // mm, machine coordinates: where the tool is, by the machine itself.
    [[nodiscard]] Point tool() const {
        hand("where");
        Point at;
        std::ifstream(log_path().string() + ".hand.at") >> at.x() >> at.y() >> at.z();
        return at;
    }
    // Moves that nothing guards: whatever moves but G38.
    [[nodiscard]] std::size_t unguarded_moves() const { return told("mdi G0") + told("mdi G1") + told("jog") + told("auto"); }
    void end() const { std::ofstream(log_path().string() + ".gone").flush(); }

private:
    [[nodiscard]] std::filesystem::path log_path() const { return folder_ / "log"; }

    std::filesystem::path folder_;
    std::unique_ptr<ChildStream> program_;
    std::string address_;
};

// For the contracts: touches are exact, and it moves 20 times as fast as it says. `wrong`: one word of what the module reads.
inline nlohmann::json small_ball(double radius, const Point& center, const Point& start, const std::string& wrong = {}) {
    const auto list = [](const Point& p) { return nlohmann::json::array({p.x(), p.y(), p.z()}); };
    nlohmann::json json{{"radius", radius}, {"center", list(center)}, {"start", list(start)}, {"servo", 1e-6},
                        {"pace", 20},       {"acceleration", 200}};
    if (!wrong.empty()) json[wrong] = true;
    return json;
}

}  // namespace palpate::test
