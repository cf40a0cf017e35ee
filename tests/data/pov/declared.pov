#declare A = 1;
box { <0,0,0>, <A,1,1> }
