// A quarter of the ground around a cylindrical cavity of a radius of 1 m, 10 m far, for Gmsh:
//
//     gmsh cavity.geo -2 -format msh41 -setnumber Mesh.Binary 0 -o cavity.msh
//
// Quadrilaterals: 0.15 m at the cavity, 1.5 m far from it. What is in no physical group is not saved.
Mesh.RecombineAll = 1;
Mesh.RecombinationAlgorithm = 3;
Mesh.Algorithm = 8;
Point(1) = {0, 0, 0};
Point(2) = {1, 0, 0, 0.15};
Point(3) = {10, 0, 0, 1.5};
Point(4) = {10, 10, 0, 1.5};
Point(5) = {0, 10, 0, 1.5};
Point(6) = {0, 1, 0, 0.15};
Line(1) = {2, 3};
Line(2) = {3, 4};
Line(3) = {4, 5};
Line(4) = {5, 6};
Circle(5) = {6, 1, 2};
Curve Loop(1) = {1, 2, 3, 4, 5};
Plane Surface(1) = {1};
Physical Surface("ground") = {1};
Physical Curve("cavity") = {5};
Physical Curve("far") = {2, 3};
