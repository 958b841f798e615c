// Read by the test of `literals` alone, which must find five numbers here: not 1e-9, which is in a comment.
/* Nor 1e-9
   1e-9 */
constexpr double decimal = 0.0001, exponent = 1e-9, hexadecimal = 0x1p-20, separated = 0.000'001;
constexpr float single = 2e-6f;
constexpr double large = 1.1e-2, edge = 1e-2, whole = 0x1e, far = 1e9, zero = 0.0;
constexpr char text[] = "1e-9", raw[] = R"(1e-9)", quote = '"';
