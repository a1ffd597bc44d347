// What a call says when it fails.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace palpate {

template <class Fault>
std::string message_of(const std::function<void()>& call) {
    try {
        call();
    } catch (const Fault& fault) {
        return fault.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return "";
}

inline void expect_says(const std::string& message, const std::string& what) {
    EXPECT_NE(message.find(what), std::string::npos) << message;
}

}  // namespace palpate
