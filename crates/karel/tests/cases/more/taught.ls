/PROG TAUGHT
/ATTR
/MN
   1:J P[2] 10% FINE ;
   2:L P[1] 100mm/sec FINE ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   600.000  mm,	Y =   100.000  mm,	Z =   400.000  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[2]{
   GP1:
	UF : 0, UT : 1,
	J1=     0.000 deg,	J2=    10.000 deg,	J3=   -20.000 deg,
	J4=     0.000 deg,	J5=   -70.000 deg,	J6=     0.000 deg
};
/END
