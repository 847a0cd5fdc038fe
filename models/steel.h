// What arms are made of, where a size is to be compared with it.
#pragma once

namespace sagitta {

constexpr double kSteelPerKelvin = 11.5e-6;  // 1/K, linear expansion, as in the sizes of thermal_growth

}  // namespace sagitta
