// three boxes
#version 3.7;
/* no box { <9,9,9>, <10,10,10> } /* here */ */
camera { location <0, 2, -10> look_at <0, 0, 0> }
box { <-1, -1, -1>, <1, 1, 1> pigment { color rgb <1, 0, 0> } }
box{<4,.5,2>,<2,-1.5e0,-2>texture{pigment{image_map{png "a}b.png"}}}no_shadow}
box { <-6, -2, -0.001>, <-3, 2, 0.001> finish { phong 0.5 } }
