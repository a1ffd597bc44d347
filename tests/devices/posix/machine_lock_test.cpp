#include "devices/posix/machine_lock.h"

#include <gtest/gtest.h>

#include <string>

#include "devices/errors.h"

namespace palpate::machine_lock_test {
namespace {

TEST(MachineLock, IsHeldByOneAtATime) {
    for (const std::string& name : {std::string("arm"), std::string(50, 'a') + std::string(300, 'b')}) {
        {
            const MachineLock lock = MachineLock::of_name(name);
            EXPECT_THROW((void)MachineLock::of_name(name), DeviceError) << name;
        }
        const MachineLock again = MachineLock::of_name(name);
    }
}

TEST(MachineLock, LongNamesThatEndAlikeAreOfTwoMachines) {
    const std::string end(300, 'b');
    const MachineLock left = MachineLock::of_name("left" + end);
    const MachineLock right = MachineLock::of_name("right" + end);
    EXPECT_THROW((void)MachineLock::of_name("left" + end), DeviceError);
}

}  // namespace
}  // namespace palpate::machine_lock_test
