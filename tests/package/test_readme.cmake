# The README's example is a source that is compiled and run.
cmake_minimum_required(VERSION 3.25)
file(READ "${readme}" text)
file(READ "${example}" source)
string(FIND "${text}" "```cpp\n${source}```\n" place)
if(place EQUAL -1)
    message(FATAL_ERROR "README.md does not show ${example} as it is: put the file between ```cpp and ```")
endif()
