// Columns of a board's surfaces, rows that the kernel `lay_out` fills; see engine/physics/surface.py.

export const X = 0;
export const Y = 1;
export const DISTANCE = 2; // of a circle: distance of the ball's centre at contact; 0 for a line
export const DISTANCE2 = 3; // of a circle: its square
export const LENGTH = 3; // of a line
export const TX = 4;
export const TY = 5;
export const END_X = 10; // of a line: its last end
export const END_Y = 11;
export const OWNER = 15; // the row itself, unless its surface is a part of another's
export const COLUMNS = 16;
