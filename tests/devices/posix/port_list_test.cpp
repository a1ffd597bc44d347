// A made-up /sys with the links that the kernel makes.
#include "devices/posix/port_list.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

namespace palpate::port_list_test {
namespace {

namespace fs = std::filesystem;

class PortList : public ::testing::Test {
protected:
    PortList() {
        std::string name = (fs::temp_directory_path() / "palpate_sysfs_XXXXXX").string();
        root_ = mkdtemp(name.data());
        fs::create_directories(root_ / "class/tty");
    }
    ~PortList() override { fs::remove_all(root_); }

    void write(const fs::path& file, const std::string& line) const {
        fs::create_directories((root_ / file).parent_path());
        std::ofstream(root_ / file) << line << '\n';
    }
    // A port of a USB device with those properties, as the kernel lays it out.
    void add_usb(const std::string& tty, const std::string& bus) const {
        const fs::path usb = "devices/usb1/" + bus;
        write(usb / "idVendor", "2341");
        write(usb / "idProduct", "0043");
        write(usb / "manufacturer", "Arduino");
        write(usb / "product", "Uno");
        write(usb / "serial", "123ABC");
        const fs::path interface = root_ / usb / (bus + ":1.0");
        fs::create_directories(interface / "tty" / tty);
        fs::create_directories(root_ / "bus/usb/drivers/cdc_acm");
        fs::create_directory_symlink(root_ / "bus/usb/drivers/cdc_acm", interface / "driver");
        fs::create_directory_symlink(interface, interface / "tty" / tty / "device");
        fs::create_directory_symlink(interface / "tty" / tty, root_ / "class/tty" / tty);
    }

    fs::path root_;
};

TEST_F(PortList, AUsbPortSaysWhoItIs) {
    add_usb("ttyACM1", "1-2");
    add_usb("ttyACM0", "1-1");
    const std::vector<PortInfo> ports = list_ports(root_);
    ASSERT_EQ(ports.size(), 2U);
    EXPECT_EQ(ports[0], (PortInfo{"/dev/ttyACM0", "2341:0043", "Arduino", "Uno", "123ABC", "cdc_acm"}));
    EXPECT_EQ(ports[1].path, "/dev/ttyACM1");
}

TEST_F(PortList, ConsolesAndPortsWithoutHardwareAreLeftOut) {
    fs::create_directories(root_ / "class/tty/tty1");
    fs::create_directories(root_ / "devices/platform/serial8250");
    for (const std::string tty : {"ttyS0", "ttyS4"}) {
        fs::create_directories(root_ / "class/tty" / tty);
        fs::create_directory_symlink(root_ / "devices/platform/serial8250", root_ / "class/tty" / tty / "device");
    }
    write("class/tty/ttyS0/type", "4");
    write("class/tty/ttyS4/type", "0");
    const std::vector<PortInfo> ports = list_ports(root_);
    ASSERT_EQ(ports.size(), 1U);
    EXPECT_EQ(ports[0].path, "/dev/ttyS0");
    EXPECT_EQ(ports[0].usb_id, "");
}

TEST_F(PortList, AComputerWithoutAnyHasNone) {
    fs::remove_all(root_ / "class");
    EXPECT_TRUE(list_ports(root_).empty());
}

}  // namespace
}  // namespace palpate::port_list_test
