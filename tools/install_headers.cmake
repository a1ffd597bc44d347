# Installs the headers that users include. Run by `cmake --install`, which says where ours are (`source`) and where theirs belong below the
# prefix (`include_folder`).
#
# In the sources paths are includes, "planner/geometry.h". Whoever uses the package has only <prefix>/include to search, and it is not
# ours alone: there they are "palpate/planner/geometry.h".
cmake_minimum_required(VERSION 3.25)

# What nobody outside needs: how the planner works inside, and what helps sources.
set(inner "/internal/|^planner/(delaunay|inference|plausibility|loop|motion|tolerance)/"
          "|^planner/(criteria|union_find)[.]h$|^sim/objects/(box_mesh|capsule_contact|cover|crofton|parallelogram|pose|triangle_tree)[.]h$|^sim/tool/|^sim/probe/axis_play[.]h$")
string(CONCAT inner ${inner})

file(GLOB_RECURSE headers RELATIVE "${source}" "${source}/planner/*.h" "${source}/devices/*.h" "${source}/sim/*.h")
list(FILTER headers EXCLUDE REGEX "${inner}")

cmake_path(ABSOLUTE_PATH include_folder BASE_DIRECTORY "${CMAKE_INSTALL_PREFIX}")
set(ours "#include \"((planner|devices|sim|config|tools)/[^\"]+)\"")
foreach(header IN LISTS headers)
    file(READ "${source}/${header}" text)
    string(REGEX MATCHALL "${ours}" includes "${text}")
    foreach(include IN LISTS includes)
        string(REGEX REPLACE "${ours}" "\\1" included "${include}")
        if(NOT included IN_LIST headers)
            message(FATAL_ERROR "${header} is installed and includes ${included}, which is not (tools/install_headers.cmake)")
        endif()
    endforeach()
    string(REGEX REPLACE "${ours}" "#include \"palpate/\\1\"" text "${text}")
    file(WRITE "$ENV{DESTDIR}${include_folder}/palpate/${header}" "${text}")
    list(APPEND CMAKE_INSTALL_MANIFEST_FILES "${include_folder}/palpate/${header}")
endforeach()
message(STATUS "Installed headers: ${include_folder}/palpate")
