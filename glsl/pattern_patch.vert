#version 450
// Hands the number of a coarse triangle to the tessellator: gl_PrimitiveID cannot be trusted there.
layout(location = 0) in uint triangle;
layout(location = 0) out uint number;

void main()
{
    number = triangle;
}
