// Precompiled: what most sources of the simulator read.
#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <random>
#include <string>
#include <vector>
