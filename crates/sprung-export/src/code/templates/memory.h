/*
 * Memory of presliding friction and of the hysteresis of springs. One of zeros begins with its first positions. The other functions
 * have no memory: there, the elements slide.
 */
struct @memory {
    @real elements[12 * §JOINTS];
    @real position[2 * §JOINTS];
    int has_begun;
};

/* Moves the memory on to the positions of the next sample, for inverse dynamics with memory. */
void @remember(struct @memory *own, const @real q_rad[§JOINTS], const @real phi_rad[§JOINTS]);

